"""labrig.effects"""
