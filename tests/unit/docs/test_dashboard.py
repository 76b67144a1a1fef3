"""What the page of the dashboard says of the sample's repair plan is what is offered there."""

from __future__ import annotations

import re

from atleak.analysis.repair.choice import OfferedRepairs
from atleak.common.verdicts import Verdict
from atleak.diagnosis.diagnosis import Diagnosis
from tests.unit.docs.pages import text_of

TEXT = " ".join(text_of("docs/dashboard.md").split())


def test_the_plan_offers_as_many_lands_within_their_limits_as_the_page_says(sample: Diagnosis) -> None:
    offered = [each for each in OfferedRepairs(sample).all if not each.called_for]
    fine = [land for land in sample.lands if land.verdict is Verdict.OK]
    assert {each.lands[0].key for each in offered} <= {land.key for land in fine}
    assert f"*Lands within their limits ({len(offered)})*" in TEXT
    (said,) = re.findall(r"Of the sample (\d+) of (\d+) lands are ok; (\d+) of them are as tight as new", TEXT)
    tight = [land for land in fine if land.state.radial_clearance <= land.state.land.new_clearance]
    assert [int(number) for number in said] == [len(fine), len(sample.lands), len(tight)]
