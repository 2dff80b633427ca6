"""The beginning of every page, the targets of its links, and the plots of fits, diagnoses and campaigns."""

import hashlib
import json
import re
import shlex
import subprocess

import pytest

from browser import assert_readable, browser, needs_chromium, opened  # noqa: F401
from hidden import product
from made_pages import PAGES, made_pages
from own_actuators import actuator
from own_program import PROGRAM

pytestmark = [product.needs_program(), needs_chromium]

VERDICTS = {
    "inspection": ("usable", "of 2 records"),
    "fit": ("converged", "rms on multisine.csv"),
    "diagnosis": ("named", "Missing: backlash"),
    "comparison": ("limits", "of 1 pairs"),
    "campaign": ("1 open answer", "1 named, 1 refused; 1 of 3 records was refused"),
}
RECORDS = {
    "inspection": ("sweep", "multisine"),
    "fit": ("sweep", "random", "multisine"),
    "diagnosis": ("sweep", "random", "multisine"),
    "comparison": (),
    "campaign": ("sweep", "random"),
}
# In addition to the earlier ones: overlay, loop, residuals, responses.
PICTURES = {
    "fit/fit.html": (
        "Response",
        "Response: measured minus model",
        "Residual over frequency",
        "A record that was not fitted",
        "Residual over time",
    ),
    "diagnosis/report.html": (
        "Residual over position",
        "Residual over rate",
        "Residual over the time since a reversal",
        "Gain and lag over amplitude",
    ),
}


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("contents")
    actuator("demo", "-o", folder, "--force")
    return made_pages(folder)


def facts(page):
    return dict(zip(page.locator(".facts dt").all_inner_texts(), page.locator(".facts dd").all_inner_texts()))


@pytest.mark.parametrize("name", PAGES)
def test_every_page_begins_with_what_it_was_made_from(browser, demo, name):  # noqa: F811
    kind = name.split("/")[0]
    with opened(browser, demo / name) as page:
        verdict = page.locator("ul.verdicts").first.inner_text()
        head, line = facts(page), page.locator("pre.command").inner_text()
        files = page.locator("table").first.inner_text()
        begins = [page.locator(one).first.bounding_box()["y"] for one in ("h1", "ul.verdicts", ".facts", "pre.command", "table", "h2")]
    assert all(words in verdict for words in VERDICTS[kind]), verdict
    assert begins == sorted(begins)
    assert head["version"] == f"actuator {actuator('--version').split()[1]}" and head["options"]
    assert shlex.split(line)[:2] == ["actuator", {"diagnosis": "demo", "inspection": "inspect", "comparison": "compare"}.get(kind, kind)]
    for record in RECORDS[kind]:
        assert hashlib.sha256((demo / f"{record}.csv").read_bytes()).hexdigest() in files, (record, files)
    of_model = {"fit": demo / "fit" / "rudder's.toml", "comparison": demo / "fitted.toml", "diagnosis": demo / "fitted.toml"}.get(kind)
    if kind in ("comparison", "diagnosis"):
        assert hashlib.sha256(of_model.read_bytes()).hexdigest() in files + head["model"]
    if kind == "fit":
        assert head["model"] == str(of_model) and "--order 2" in head["options"] and "--check" not in head["options"]


@pytest.mark.parametrize("name", ["fit/fit.html", "comparison/compare.html"])
def test_the_command_line_of_a_page_makes_it_again(browser, demo, name):  # noqa: F811
    """In a shell, including quotes. An existing file is not overwritten without --force."""
    with opened(browser, demo / name) as page:
        line = page.locator("pre.command").inner_text()
        page.locator("pre.command + button.copy").click()
        assert page.locator("pre.command + button.copy").inner_text() == "copied"
    shell = f"{shlex.quote(str(PROGRAM))} {line.removeprefix('actuator ')}"
    refused = subprocess.run(["sh", "-c", shell], capture_output=True, text=True)
    assert refused.returncode == 2 and "--force" in refused.stderr, refused
    first = (demo / name).read_text()
    done = subprocess.run(["sh", "-c", f"{shell} --force"], capture_output=True, text=True)
    assert done.returncode == 0, done
    again = (demo / name).read_text()
    assert again.replace(" --force", "") == first.replace("none: all have their defaults", "")


@pytest.mark.parametrize("name, captions", PICTURES.items())
def test_pictures_of_a_fit_and_of_what_a_difference_depends_on(browser, demo, name, captions):  # noqa: F811
    with opened(browser, demo / name) as page:
        shown = page.locator("figcaption b").all_inner_texts()
        assert set(captions) <= set(shown), shown
        for caption in captions:
            figure = page.locator("figure").nth(shown.index(caption))
            drawn = figure.locator(".items path[data-name]").evaluate_all("paths => paths.map(path => path.getAttribute('d').length)")
            assert drawn and max(drawn) > 100, caption


def test_a_fit_states_errors_correlations_and_what_it_predicts(browser, demo):  # noqa: F811
    found = json.loads(
        actuator("fit", demo / "sweep.csv", demo / "random.csv", "--check", demo / "multisine.csv", "--order", "2", "--json")
    )
    with opened(browser, demo / "fit" / "fit.html") as page:
        tables = page.locator("table").all_inner_texts()
        text = page.inner_text("body")
    parameters = next(table for table in tables if "standard error" in table)
    assert all(estimate["name"] in parameters and estimate["unit"] in parameters for estimate in found["estimates"])
    correlations = next(table for table in tables if table.startswith("correlation"))
    assert f"{found['correlations'][0][1]:.3f}" in correlations
    left = next(table for table in tables if "% of the position" in table)
    assert f"{100 * found['checks'][0]['residual_share']:.2f}" in left
    assert all(note in text for note in found["notes"] + found["warnings"])
    assert "coherence" in page_svg_texts(demo / "fit" / "fit.html")


def page_svg_texts(path):
    return path.read_text().split("<footer>")[0]


def test_the_evidence_is_a_bar_for_each_explanation(browser, demo):  # noqa: F811
    diagnosis = json.loads((demo / "diagnosis" / "diagnosis.json").read_text())
    with opened(browser, demo / "diagnosis" / "report.html", "phone") as page:
        picture = page.locator("svg", has_text="Residual of each explanation")
        words = " ".join(picture.locator("text").all_text_contents())
        bars = picture.locator("rect.bar").evaluate_all("bars => bars.map(bar => bar.width.baseVal.value)")
        assert_readable(page, pictures=10 + len(diagnosis["where"]))
    names = [candidate["name"] for candidate in diagnosis["candidates"]]
    assert all(name in words for name in names) and "noise" in words
    assert len(bars) == len(names)
    rms = [candidate["check_rms"] for candidate in diagnosis["candidates"]]
    assert sorted(range(len(rms)), key=rms.__getitem__) == sorted(range(len(bars)), key=bars.__getitem__)


@pytest.mark.slow
def test_leads_that_take_next_to_nothing_are_in_the_json_alone(browser, tmp_path):  # noqa: F811
    _, arguments = product.write_case("rig_effect", 180003, tmp_path)
    diagnosis, _ = product.diagnose(product.program(), tmp_path, arguments=arguments)
    shares = {lead["name"]: lead["share"] for lead in diagnosis["leads"]}
    assert any(share < 0.01 for share in shares.values()), shares
    with opened(browser, tmp_path / "diagnosis" / "report.html") as page:
        listed = page.locator("table", has_text="why it is not named").locator("tbody tr td:first-child").all_inner_texts()
    assert listed == [name for name, share in shares.items() if share >= 0.01]


def test_a_campaign_says_doubts_as_loudly_as_names_and_links_everything(browser, demo):  # noqa: F811
    path = demo / "campaign" / "report.html"
    with opened(browser, path) as page:
        links = page.locator("a").evaluate_all("links => links.map(link => link.getAttribute('href'))")
        statements = page.locator("ul.verdicts li").all_inner_texts()
        sizes = page.locator("ul.verdicts .verdict").evaluate_all("all => all.map(one => getComputedStyle(one).fontSize)")
        picture = page.locator("svg", has_text="Differences before and after")
        rows = picture.locator("text.row").all_text_contents()
        verdicts = page.locator("td.tone").all_inner_texts()
    assert len(set(sizes)) == 1
    assert any("nowhere" in one and one.startswith("refused") for one in statements), statements
    assert any("rudder-worn-unloaded" in one and one.startswith("named") for one in statements), statements
    assert verdicts == ["named", "refused"] or verdicts == ["refused", "named"]
    assert rows[0] == "rudder-worn-unloaded" and float(rows[1].split()[0]) > 1.5 > float(rows[1].split()[2])
    folder = "diagnoses/rudder-worn-unloaded"
    wanted = {f"{folder}/{name}" for name in ("report.html", "diagnosis.json", "model.toml", "model.fmu")}
    assert wanted | {"models/rudder-worn-unloaded.toml"} == set(links)
    assert all((path.parent / link).is_file() for link in links)
    with opened(browser, path.parent / folder / "report.html") as page:
        assert page.locator("pre.command").inner_text().startswith("actuator campaign ")


@pytest.mark.slow
def test_the_tables_of_a_campaign_of_all_conditions_fit_into_a_small_window(browser, tmp_path):  # noqa: F811
    actuator("generate-campaign", "-o", tmp_path / "bact", "--duration", 25)
    actuator("campaign", tmp_path / "bact" / "manifest.toml", "-o", tmp_path / "results", "--no-diagnosis")
    with opened(browser, tmp_path / "results" / "report.html") as page:
        page.set_viewport_size({"width": 1200, "height": 800})
        wide = "tables => tables.filter(table => table.scrollWidth > table.clientWidth).map(table => table.innerText.slice(0, 60))"
        assert page.locator(".scroll").count() >= 4
        assert page.locator(".scroll").evaluate_all(wide) == []
        numbers = page.locator("td.number", has_text="±").evaluate_all("cells => cells.map(cell => cell.textContent)")
    assert len(numbers) > 100 and all(re.fullmatch(r"-?[\d.]+( ± |±)[\d.]+", number) for number in numbers), numbers[:3]


def test_residuals_of_rounding_errors_have_an_axis_that_can_be_read(browser, tmp_path):  # noqa: F811
    """A record without noise has a residual of 1e-13 deg: a power of ten in the label, also when the plot is zoomed."""
    for kind in ("sweep", "random"):
        actuator("excite", kind, "--duration", 25, "-o", tmp_path / f"{kind}-command.csv")
        actuator("simulate", "te-early-unloaded", tmp_path / f"{kind}-command.csv", "-o", tmp_path / f"{kind}.csv")
    actuator("fit", tmp_path / "sweep.csv", "--check", tmp_path / "random.csv", "--report", tmp_path / "fit.html")
    with opened(browser, tmp_path / "fit.html") as page:
        svg = page.locator("figure", has_text="Residual over time").locator("svg")
        svg.scroll_into_view_if_needed()
        seen = []
        for _ in range(2):
            texts = svg.locator("text:visible")
            seen.append(texts.all_text_contents())
            left = svg.bounding_box()["x"]
            assert all(text.bounding_box()["x"] >= left for text in texts.all()), seen[-1]
            box = svg.locator("g.items").bounding_box()
            page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + 0.5 * box["height"])
            page.mouse.down()
            page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"], steps=4)
            page.mouse.up()
        whole, zoomed = seen
    for texts in seen:
        assert any(re.fullmatch(r"residual, 10⁻1?[⁰¹²³⁴⁵⁶⁷⁸⁹]+\xa0deg", text) for text in texts), texts
        ticks = [text.replace("−", "-") for text in texts if re.fullmatch(r"[−\d.]+", text)]
        assert len(ticks) >= 6 and len(set(ticks)) >= len(ticks) - 1 and all(abs(float(tick)) <= 100 for tick in ticks), texts
    assert whole != zoomed
