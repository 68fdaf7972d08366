"""labrig.physics"""
