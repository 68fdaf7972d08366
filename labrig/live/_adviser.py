"""Follows a campaign with a diagnosis: what it looked at, what it decided, and the set-points that follow from it."""

from typing import Any

from labrig.campaign import Actuate, Ask, Note, Record, RigInfo, Step, Steps, Vent
from labrig.contents import ProgrammePoint
from labrig.live._adapt import Range, first_probe, steps_of
from labrig.live._look import Look
from labrig.live._looker import Looker
from labrig.live._settings import Settings
from labrig.live._words import look_line
from labrig.run_contents import Advice, LiveAnswer, LiveQuestion, RangeContent

FIRST = 12
"""Captures before the first look: with fewer nothing can be said."""


class LiveDiagnosis:
    """The adviser of a campaign (`labrig.campaign.Adviser`).

    Before it moves on to the next set-point the campaign asks; the answer is what the process of `looker` has found by
    then. On a real clock nobody waits for it. On a simulated one, where captures take no time, the campaign waits for
    every look that is due (`waits`), so that it is the same again and again. `planned` captures are made at most;
    within `range_kpa`, if it is given, probes that tell apart what is open take the place of the plan's set-points.
    """

    def __init__(
        self,
        settings: Settings,
        planned: int,
        looker: Looker | None,
        *,
        waits: bool,
        range_kpa: Range | None = None,
    ) -> None:
        self.settings, self.rule, self.planned = settings, settings.rule(), planned
        self.looks: list[Look] = []
        self.ended: str | None = None
        self._looker, self._waits, self._range = looker, waits, range_kpa
        self._begin()

    def _begin(self) -> None:
        self.looks, self.ended = [], None
        self._asked_at = self._captures = 0
        self._points: list[ProgrammePoint] = []

    def follow(self, plan: Steps, rig: RigInfo) -> Steps:
        """The plan, or what is proposed in its place, with a question before each set-point, to where it is to end."""
        self._begin()
        asked, adapted = FIRST - 1, False
        step: Step | None = next(plan, None)
        while step is not None and not (adapted and self._captures >= self.planned):
            if isinstance(step, Actuate | Vent) and self._captures > asked:
                asked = self._captures
                yield from self._ask()
                if self.ended is not None:
                    plan.close()
                    yield Note(f"diagnosis: the campaign ends here, vented: {self.ended}")
                    return
                if self._points:
                    adapted = True
                    yield from self._probe(rig)
                    continue
            result = yield step
            self._count(step, result)
            try:
                step = plan.send(result)
            except StopIteration:
                step = None
        plan.close()
        if self._captures > asked:
            yield from self._ask()

    def _ask(self) -> Steps:
        answered = yield Ask(self._captures)
        self._learn(answered.content)

    def _probe(self, rig: RigInfo) -> Steps:
        """The next probe, whole, as far as there are captures left for it."""
        count = first_probe(self._points, self.planned - self._captures)
        probe, self._points = self._points[:count], self._points[count:]
        steps = steps_of(probe, rig)
        step = next(steps, None)
        while step is not None:
            result = yield step
            self._count(step, result)
            try:
                step = steps.send(result)
            except StopIteration:
                return

    def _count(self, step: Step, result: Any) -> None:
        self._captures += isinstance(step, Record) and not result.missed

    def _learn(self, content: Advice) -> None:
        """Take in an answer, a new one or one that was logged: nothing else counts for what follows."""
        if found := content.get("look"):
            self.looks.append(Look.from_dict(found))
        if "points" in content:
            self._points += content["points"]
        self._asked_at = max(self._asked_at, int(content.get("asked") or 0))
        self.ended = content.get("stop")

    def advise(self, ask: Ask, spent_s: float) -> Advice:
        """What is known by now: `look` if there is a new one, `stop` if it is enough, the look as words to `say`."""
        content: Advice = {}
        self._take(None if self._looker is None else self._looker.found(), content)
        why = self._why(content, ask, spent_s)
        if why is None and self._looker is not None and self._looker.idle and self._due(ask):
            self._looker.ask(self._question(ask, len(self._points) + len(content.get("points", ()))))
            content["asked"] = ask.captures
            if self._waits:
                self._take(self._looker.wait(), content)
                why = self._why(content, ask, spent_s)
        if why is not None:
            content["stop"] = why
            if looks := self._looks(content):
                content["probability"] = self.rule.at_a_stop(looks[-1])
        return content

    def _question(self, ask: Ask, left: int) -> LiveQuestion:
        """A look and, when what was proposed before is nearly done, the next set-points within the plan's range."""
        if self._range is None or left > self.settings.every:
            return {"captures": ask.captures}
        within = self._range
        adapt: RangeContent = {
            "low_kpa": within.low_kpa,
            "high_kpa": within.high_kpa,
            "slew_kpa_s": within.slew_kpa_s,
        }
        return {"captures": ask.captures, "adapt": adapt}

    def _due(self, ask: Ask) -> bool:
        new = ask.captures - self._asked_at
        return not self._asked_at or new >= self.settings.every or ask.captures >= self.planned

    def _why(self, content: Advice, ask: Ask, spent_s: float) -> str | None:
        return self.rule.stop(self._looks(content), self.planned - ask.captures, spent_s, ask.captures)

    def _looks(self, content: Advice) -> list[Look]:
        return [*self.looks, *([Look.from_dict(content["look"])] if "look" in content else [])]

    @staticmethod
    def _take(found: LiveAnswer | None, content: Advice) -> None:
        """Add to an answer what the process has found."""
        if found is None:
            return
        if "look" in found:
            look = Look.from_dict(found["look"])
            content["look"], content["say"] = look.to_dict(), look_line(look)
        if "points" in found:
            content["points"] = found["points"]
        if "trouble" in found:
            content["trouble"] = found["trouble"]
