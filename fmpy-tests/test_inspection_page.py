"""`inspection.html` in headless Chromium: a healthy record, one with a gap, spikes and a drift, and one that is no response."""

import numpy as np
import pytest

from browser import SCREENS, assert_readable, browser, needs_chromium, opened  # noqa: F401
from hidden import product
from own_actuators import actuator, read_csv, write_csv

pytestmark = [product.needs_program(), needs_chromium]


@pytest.fixture(scope="module")
def inspected(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inspection")
    rng = np.random.default_rng(208452)
    actuator("excite", "steps", "--amplitude", "2", "--duration", "25", "-o", folder / "command.csv")
    actuator("simulate", "us-late-loaded", folder / "command.csv", "-o", folder / "response.csv")
    columns = {name: values for name, values in read_csv(folder / "response.csv").items() if name in ("time", "command", "position")}
    noise = rng.normal(scale=0.02, size=len(columns["time"]))
    write_csv(folder / "healthy.csv", **columns | {"position": columns["position"] + noise})
    spoiled = columns["position"] + noise + 0.05 * columns["time"]
    spoiled[[3500, 4000]] += 2.0
    kept = np.r_[0:1000, 1060 : len(noise)]
    write_csv(folder / "spoiled.csv", **{name: values[kept] for name, values in (columns | {"position": spoiled}).items()})
    write_csv(folder / "dead.csv", **columns | {"position": noise})
    records = [folder / f"{name}.csv" for name in ("healthy", "spoiled", "dead")]
    actuator("inspect", *records, "-o", folder / "out")
    return folder / "out" / "inspection.html"


@pytest.mark.parametrize("size, scheme", SCREENS)
def test_the_inspection_reads_on_every_screen(browser, inspected, output_folder, size, scheme):  # noqa: F811
    with opened(browser, inspected, size, scheme) as page:
        page.screenshot(path=output_folder / f"inspection-{size}-{scheme}.png", full_page=True)
        assert_readable(page, pictures=10)


def test_every_record_has_its_verdict_its_findings_and_what_to_do(browser, inspected):  # noqa: F811
    with opened(browser, inspected) as page:
        head = "\n".join(page.locator("ul.verdicts").all_inner_texts())
        text = page.inner_text("body")
    for words in ("usable: ", "usable with care: ", "refused: ", "healthy.csv", "spoiled.csv", "dead.csv", "does not follow"):
        assert words in head, words
    for words in ("a gap in which about 60 samples", "spikes in the position: 2", "drifts by", "sensor warm", "from the parts at rest"):
        assert words in text, words
