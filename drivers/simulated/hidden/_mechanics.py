"""Effects inside the mechanics that depend on the present load alone."""

import numpy as np

from drivers.simulated.hidden._base import Array, Hidden, resisted


def neighbours(weight: Array) -> Array:
    """How much chambers share of the surface, (C, C), zero diagonal, largest entry one; `weight` (M, C)."""
    norm = np.linalg.norm(weight, axis=0)
    shared = weight.T @ weight / np.outer(norm, norm)
    np.fill_diagonal(shared, 0.0)
    return shared / max(shared.max(), 1e-12)


class Coupling(Hidden):
    """Bellies that touch: an inflated neighbour presses a chamber flat, less and less the further it is out.

    d_i becomes d_i (1 - s sum_j a_ij tanh(d_j / d0)); `strength` s: dimensionless.
    """

    name = "coupling"
    natural = 0.05

    def prepare(self) -> None:
        random, count = self.setting.random, self.setting.chambers
        chance = np.exp(0.4 * random.normal(size=(count, count)))
        self.pairs = neighbours(self.setting.body.weight) * chance
        self.scale_mm = random.uniform(0.35, 0.7) * self.setting.largest_mm

    def deflect(self, time_s: Array, step_s: Array, deflection_mm: Array) -> Array:
        """Deflections beside inflated neighbours."""
        del time_s, step_s
        pressed = np.tanh(deflection_mm / self.scale_mm) @ self.pairs.T
        return deflection_mm * (1.0 - self.strength * pressed)


class Stiffening(Hidden):
    """A fibre-filled silicone: exponential stiffening with stretch (Fung 1967), on top of the membrane's
    cubic.

    `strength`: dimensionless factor of the exponential term.
    """

    name = "stiffening"
    natural = 0.1

    def prepare(self) -> None:
        self.share = self.setting.varied(0.15)
        self.exponent = self.setting.random.uniform(1.5, 3.0)

    def deflect(self, time_s: Array, step_s: Array, deflection_mm: Array) -> Array:
        """Deflections of the stiffer membrane."""
        del time_s, step_s
        body, a = self.setting.body, self.exponent
        limit, gain = body.limit_mm, body.compliance_mm_per_kpa

        def resistance(d: Array) -> tuple[Array, Array]:
            y = (d / limit) ** 2
            scale = self.strength * self.share / gain
            return scale * d * np.expm1(a * y), scale * (np.expm1(a * y) + 2.0 * a * y * np.exp(a * y))

        return resisted(body, deflection_mm, resistance)


class Tension(Hidden):
    """The top membrane was mounted with more stretch than the drawing says: stiffer at first, not when far
    out.

    `strength`: the surplus of linear stiffness, as a part of it.
    """

    name = "tension"
    natural = 0.08

    def deflect(self, time_s: Array, step_s: Array, deflection_mm: Array) -> Array:
        """Deflections under more tension."""
        del time_s, step_s
        stiffness = self.strength / self.setting.body.compliance_mm_per_kpa
        return resisted(self.setting.body, deflection_mm, lambda d: (stiffness * d, stiffness + 0.0 * d))


class Contact(Hidden):
    """A strut behind one chamber or two is met at some deflection: Hertzian resistance beyond it.

    `strength`: contact stiffness at 10 mm beyond the gap as a multiple of the membrane's own.
    """

    name = "contact"
    natural = 0.5

    def prepare(self) -> None:
        random, count = self.setting.random, self.setting.chambers
        touched = random.permutation(count)[: min(count, int(random.integers(1, 3)))]
        self.touches = np.isin(np.arange(count), touched).astype(float)
        self.gap_mm = self.setting.largest_mm * random.uniform(0.45, 0.65, size=count)

    def deflect(self, time_s: Array, step_s: Array, deflection_mm: Array) -> Array:
        """Deflections against the strut."""
        del time_s, step_s
        body = self.setting.body
        scale = self.strength * self.touches / (body.compliance_mm_per_kpa * np.sqrt(10.0))

        def resistance(d: Array) -> tuple[Array, Array]:
            deep = np.maximum(d - self.gap_mm, 0.0)
            return scale * deep**1.5, 1.5 * scale * np.sqrt(deep)

        return resisted(body, deflection_mm, resistance)
