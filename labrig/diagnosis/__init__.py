"""labrig.diagnosis"""
