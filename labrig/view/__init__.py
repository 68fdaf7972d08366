"""labrig.view"""
