"""labrig.campaign"""
