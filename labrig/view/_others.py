"""What else it could be: what is possible beside the answer, and how far the next best comes by itself."""

from labrig._text import capital, chance, listed, number, word
from labrig.contents import Ranked, Summary
from labrig.view._naming import added, names, possible

COMES_NEAR = 1.25  # a runner-up's error, as a multiple of the winner's, that is worth a thought


def what_else(summary: Summary) -> str:
    """The answer to the question what else it could be; empty where there is nothing to say."""
    verdict, units = summary.get("verdict", ""), str(summary.get("units", ""))
    chosen = set(added(summary))
    perhaps = names(possible(summary))
    others = [row for row in summary.get("ranking", []) if str(row.get("effect")) not in chosen]
    said = []
    if verdict == "confounded" and len(perhaps) == 1 and not summary.get("effects"):
        said.append(
            f"{capital(listed(perhaps))} is consistent with these data, and other laws look much the same: confirm it "
            "on a new run before you trust the name."
        )
    elif verdict == "confounded":
        said.append(
            "Each of the possible effects is consistent with these data. The wrong one would lower the error of this "
            "run and raise it on the next."
        )
    elif perhaps and verdict in ("identified", "multiple"):
        one = "it is" if len(perhaps) == 1 else "they are"
        said.append(
            f"{capital(listed(perhaps, 'or'))} may be missing too: {one} not needed here, and not ruled out."
        )
    elif verdict == "nothing_missing":
        end = f", and {listed(perhaps, 'or')} is possible, but not sure" if perhaps else ""
        said.append(f"Every effect in the library was tested; most probably none of them is missing{end}.")
    if verdict in ("identified", "multiple", "confounded") and others:
        best = min(others, key=lambda row: row.get("heldout_error", float("inf")))
        leaves = f"{number(best.get('heldout_error'))} {units}".strip()
        said.append(_next_best(summary, best, leaves))
    if len(chosen) > 1:
        said.append(_one_for_all(summary))
    return " ".join(filter(None, said))


def _one_for_all(summary: Summary) -> str:
    """Where one of several effects by itself does nearly as well as all of them."""
    chosen, error = set(added(summary)), summary.get("error", {}).get("model") or 0.0
    own = [row for row in summary.get("ranking", []) if str(row.get("effect")) in chosen]
    best = min(own, key=lambda row: row.get("heldout_error", float("inf")), default=None)
    if best is None or best.get("heldout_error", float("inf")) >= COMES_NEAR * error:
        return ""
    return (
        f"{capital(word(str(best['effect'])))} alone leaves {number(best['heldout_error'])} "
        f"{summary.get('units', '')}, hardly more than all of them together."
    )


def _next_best(summary: Summary, best: Ranked, leaves: str) -> str:
    """How far the best of the others comes by itself."""
    name, error = word(str(best["effect"])), summary.get("error", {}).get("model") or 0.0
    alone = best.get("heldout_error", float("inf"))
    if alone < error:
        return (
            f"{capital(name)} alone leaves less ({leaves}), although the evidence as a whole is against it "
            f"({chance(best.get('probability'))}): confirm the verdict with a new run of other set-points."
        )
    near = "close" if alone < COMES_NEAR * error else "clearly worse"
    return f"The best alternative, {name} alone, is {near}: it leaves {leaves} on the same captures."
