"""labrig.rig"""
