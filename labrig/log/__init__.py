"""labrig.log"""
