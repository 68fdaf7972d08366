"""A sealed chamber holds the pressure that it was filled to."""


def predict(actuation):
    """Pressure in bar, (F, 1), from the filling pressure in bar, (F, 1)."""
    return actuation
