"""Rest shape: the unloaded geometry is not the model's."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, field, motion_scale, pattern
from labrig.effects._fields import smooth_places
from labrig.effects._inside import inside
from labrig.effects._sign import Part, Sign, along_own


class RestShape(Effect):
    name = "rest_shape"
    meaning = (
        "The surface was made or mounted otherwise than modelled: each point is off by its own\n"
        "constant amount that no rigid motion removes."
    )
    acts_on = "mechanics"
    parameters = (
        Parameter("offset", "observable", meaning="constant error, for each observable"),
        Parameter("core", "mm", -10.0, 10.0, meaning="surplus of the simulator's core, along its normals"),
    )
    reference = "Y. Tian et al., RSS 2024, arXiv 2405.08935 (rest shape as source of the sim-to-real gap)"
    signature = "the same error in every capture, at every pressure and time, different from point to point"
    experiment = "one scan of the vented surface"

    def variants(self, context: Context) -> Iterator[Variant]:
        yield from inside(context, core="core_offset")
        yield Variant("offset", (Term.pattern("offset", np.ones(len(context.base))),))

    def family(self, context: Context) -> Iterator[Space]:
        """A constant offset of each observable; offsets that are smooth over the body are more probable."""
        always = np.ones(len(context.base))
        scale = motion_scale(context)
        smooth = [always[:, None] * scale * shape for shape in smooth_places(context).T]
        fields = [field(f"smooth {i}", values, 0.1) for i, values in enumerate(smooth)]
        yield Space("shape", "rest_shape", (pattern("rest", always, 0.2), *fields))

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("capture", "1", context.rows.capture.astype(float))

    def sign(self, context: Context, part: Part) -> Sign:
        load = context.rows.actuation.mean(axis=1)
        return along_own(context, part, load, "mean pressure", context.rows.actuation_unit)
