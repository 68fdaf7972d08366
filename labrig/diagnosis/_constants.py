"""Every number that decides a verdict: what it means, and where its value comes from."""

SMALL = 0.1
"""Prior sd of all effects that are said to be absent, together, in floors and as a share of what there is to explain:
nothing is exactly zero, and no formula, no base and no Jacobian is exact."""
TRACE_SHARES = (SMALL, 0.25)
"""Prior sds of a trace of an effect, as shares of what there is to explain: what another law's misfit can leave."""
P_TRACE = 0.3
"""Prior odds of a trace of an effect, against none; a trace is no name."""
LEVELS = (0.5, 1.0, 2.0)
"""Prior sd of an effect that is present, in multiples of what there is to explain: around it, a factor of two apart."""
FLOOR_SPREAD = 0.35
"""Prior sd of the logarithm of the noise's size where repeats alone say it: their scatter on the development half."""
LEAST_FLOORS = 0.25
"""The smallest effect, in floors, that is worth a name, and the prior sd of the smallest that counts as present.

Set by hand. As prior sd it was 0.5 before: with the limit of a name in its place no verdict of 96 campaigns of the
fifth portion changed, so one number is enough.
"""
SLOW_FLOORS = (0.05, 0.6)
"""Prior sds of the slow noise, in floors: hardly any, and as much as the hardest null has. Set by hand; a third one
between them changed no verdict of 96 campaigns of the fifth portion."""
P_EFFECT = 0.1
"""Prior odds, against none, of each further effect with a name, of an error of form of the base (no model is exact),
and that the law of one that is there lies in two of its spaces."""
P_UNNAMED = 0.003
"""Prior odds of each kind of structure without a name: a name explains more often than none does."""
INDEPENDENT = 2000
"""Most independent numbers that a campaign is worth, however many it has: models of neighbours are never exact."""
MATERIAL = 0.17
"""Share (root mean square) of what is explained that must be missed without an effect for it to be worth a name.

Read off 80 single effects and 36 pairs of the development half, each law left out of its spectrum: 0.12 calls misfits
of other laws effects (11 % of the singles), 0.2 loses one of a pair (39 % of the pairs right, 53 % at 0.15 to 0.17).
"""
MATERIAL_SPREAD = 0.3
"""How soft that limit is, in logarithms: of parts near it a misfit of another's law is as likely as an effect.

Chosen on 119 single effects and pairs of the third and fourth portions (right 75 at 0.15, 76 at 0.3, 73 at 0.45; a
wrong name sure in 20, 16, 16), looked at again on 192 campaigns of the fifth (129, 131, 130; 23, 20, 19).
"""
SURE = 0.75
"""Probability from which on an effect is called sure: one wrong name that is called sure weighs as much as three right
ones, so a doubt is better below it. Set after a look at what others give on portions left out (`docs/decisions`)."""
POSSIBLE = 0.1
"""Probability from which on an effect is called possible; by reason."""
INEXACT = 0.05
"""Share of what there is to explain by which a law is off its family anywhere, like noise: the median over the laws of
the development half, each left out, is 2 to 10 %. It matters where errors are tens of floors, not at two to four."""
PER_CONDITION = 5
"""Most independent numbers that one condition (set-point, what was before, octave of the time held) is worth: repeats
lower the noise, but a law is off there by the same each time."""
MOST_EFFECTS = 3
"""Most effects in one explanation."""
NEGLIGIBLE = 1e-3
"""Explanations less probable than this are left out of the sums, and directions of a free pattern of which the data say
less than this, against their prior; numerical."""
FEWEST_OBSERVATIONS = 24
"""Fewest observations (captures' means and contrasts within holds) from which anything is said."""
FREEDOM = 10
"""Coefficients that the data determine in a typical family: what an effect must outweigh."""
EVEN = 0.2
"""Share of a free pattern's variance that spreads evenly over all observables; the rest follows how the base moves."""
