"""labrig.model"""
