"""Appearance: `report.html` opened in headless Chromium on a laptop and on a phone, in light and in dark mode."""

import pytest

from browser import SCREENS, assert_readable, browser, needs_chromium, opened  # noqa: F401
from hidden import product

CASE = ("single", 57)  # backlash: a verdict, places, candidates, plots before and after

pytestmark = [product.needs_program(), needs_chromium]


@pytest.mark.parametrize("size, scheme", SCREENS)
def test_the_report_reads_on_every_screen(browser, diagnosed, output_folder, size, scheme):  # noqa: F811
    found = diagnosed(*CASE)
    with opened(browser, found.folder / "diagnosis" / "report.html", size, scheme) as page:
        page.screenshot(path=output_folder / f"report-{size}-{scheme}.png", full_page=True)
        assert_readable(page, pictures=4)


def test_the_report_begins_with_the_verdict(browser, diagnosed):  # noqa: F811
    found = diagnosed(*CASE)
    with opened(browser, found.folder / "diagnosis" / "report.html") as page:
        text = page.inner_text("body")
    assert found.diagnosis["sentence"] in text
    assert all(record["name"] in text and record["sha256"] in text for record in found.diagnosis["records"])
    named = [effect["name"] for effect in found.diagnosis["effects"]]
    assert named and all(name in text[:600] for name in named)
