"""Interactive functions of pages in a browser: values under the pointer in linked charts, zoom, sorting and copying of tables; and pages without scripts."""

import json

import numpy as np
import pytest

from browser import SIZES, assert_readable, browser, needs_chromium, opened  # noqa: F401
from hidden import product
from made_pages import PAGES, made_pages
from own_actuators import actuator, read_csv

pytestmark = [product.needs_program(), needs_chromium]


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages")
    actuator("demo", "-o", folder, "--force")
    return made_pages(folder)


@pytest.fixture(scope="module", params=PAGES)
def any_page(demo, request):
    return demo / request.param


def inside(page, chart, across, up=0.5):
    """A point in the first panel of a chart, as fractions of the panel."""
    box = page.evaluate(
        """chart => { const svg = document.querySelectorAll('svg.plot')[chart]; svg.scrollIntoView({block: 'center'});
        const [l, t, r, b] = svg.querySelector('g.panel').dataset.frame.split(' ').map(Number), m = svg.getScreenCTM();
        return [m.a * l + m.e, m.d * t + m.f, m.a * r + m.e, m.d * b + m.f]; }""",
        chart,
    )
    return box[0] + across * (box[2] - box[0]), box[3] + up * (box[1] - box[3])


def readouts(page):
    return [one.inner_text() for one in page.locator("output.readout").all()]


def ticks(page, chart):
    panel = page.locator("svg.plot").nth(chart).locator("g.panel").first
    texts = panel.locator("g.ticks text[text-anchor=middle]" if panel.locator("g.ticks").count() else "> text.own[text-anchor=middle]")
    return [float(text.replace("−", "-")) for text in texts.all_text_contents()]


def test_values_under_the_pointer_are_those_of_the_record(browser, demo):  # noqa: F811
    record = read_csv(demo / "sweep.csv")
    last = record["time"][-1]
    with opened(browser, demo / "inspection" / "inspection.html") as page:
        for share in (0.05, 0.1, 0.15):  # where the sweep is slow, so that a pixel is not a period
            page.mouse.move(*inside(page, 0, share))
            said = readouts(page)[0]
            words = dict(part.split(" ")[:2] for part in said.split(": ")[1].split(", "))
            time = float(said.split(" ")[1])
            assert time == pytest.approx(share * last, abs=0.01 * last)
            for name in ("command", "position"):
                near = np.abs(record["time"] - time) < 0.02
                value = float(words[name].replace("−", "-"))
                assert record[name][near].min() - 0.05 <= value <= record[name][near].max() + 0.05, (said, name)


def test_charts_of_one_axis_share_cursor_and_zoom(browser, demo):  # noqa: F811
    with opened(browser, demo / "inspection" / "inspection.html") as page:
        charts = page.locator("svg.plot")
        titles = [charts.nth(n).locator("title").first.text_content() for n in range(charts.count())]
        records = [n for n, title in enumerate(titles) if title == "The record"]
        spectrum = titles.index("Spectra")
        whole = {n: ticks(page, n) for n in (*records, spectrum)}
        page.mouse.move(*inside(page, records[0], 0.5))
        assert [readouts(page)[n][:5] for n in records] == ["time "] * 2 and not readouts(page)[spectrum]
        assert page.locator(".cursor").count() == 2
        page.mouse.move(*inside(page, records[0], 0.4))
        page.mouse.down()
        page.mouse.move(*inside(page, records[0], 0.6), steps=4)
        page.mouse.up()
        for n in records:
            now = ticks(page, n)
            assert min(whole[n]) < min(now) and max(now) < max(whole[n]) and len(now) >= 2, now
        assert ticks(page, spectrum) == whole[spectrum]
        page.mouse.dblclick(*inside(page, records[1], 0.5))
        assert {n: ticks(page, n) for n in whole} == whole


def test_a_loop_tells_its_nearest_point(browser, demo):  # noqa: F811
    with opened(browser, demo / "diagnosis" / "report.html") as page:
        captions = page.locator("figcaption b").all_inner_texts()
        chart = captions.index("Position against command")
        figure = page.locator("figure").nth(chart)
        number = page.evaluate("figure => [...document.querySelectorAll('svg.plot')].indexOf(figure.querySelector('svg'))", figure.element_handle())
        page.mouse.move(*inside(page, number, 0.5))
        said = figure.locator("output.readout").inner_text()
        assert said.split(":")[0] in ("measured", "before", "after") and "command" in said and "position" in said, said


def test_tables_sort_by_a_column_and_copy(browser, demo):  # noqa: F811
    with opened(browser, demo / "diagnosis" / "report.html") as page:
        table = page.locator(".scroll > table", has_text="BIC difference")
        column = table.locator("th").all_inner_texts().index("BIC difference")
        values = lambda: [float(row.locator("td").nth(column).inner_text()) for row in table.locator("tr").all()[1:]]  # noqa: E731
        assert len(values()) > 3
        table.locator("th button").nth(column).click()
        assert values() == sorted(values()) and table.locator("th").nth(column).get_attribute("aria-sort") == "ascending"
        table.locator("th button").nth(column).click()
        assert values() == sorted(values(), reverse=True)
        button = table.locator("xpath=../following-sibling::button[1]")
        button.click()
        assert button.inner_text() == "copied"


@pytest.mark.parametrize("size", ["phone", pytest.param("laptop", marks=pytest.mark.slow)])
def test_every_page_reads_with_its_tools_and_without_scripts(browser, any_page, output_folder, size):  # noqa: F811
    with opened(browser, any_page, size) as page:
        page.screenshot(path=output_folder / f"{any_page.parent.name}-{size}-tools.png", full_page=True)
        assert_readable(page, pictures=1)
        said = page.locator("h1").inner_text(), page.locator("table").count(), page.locator("svg").count()
    context = browser.new_context(java_script_enabled=False, viewport=SIZES[size])
    page = context.new_page()
    page.goto(any_page.as_uri())
    assert said == (page.locator("h1").inner_text(), page.locator("table").count(), page.locator("svg").count())
    assert page.locator("button").count() == 0 and page.locator(".tools").count() == 0
    context.close()


def test_print_is_black_on_white_without_tools(browser, any_page, output_folder):  # noqa: F811
    with opened(browser, any_page, scheme="dark") as page:
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 24, 28)"
        page.emulate_media(media="print", color_scheme="dark")
        assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
        paper = page.evaluate("getComputedStyle(document.querySelector('.plot .paper')).fill")
        assert paper == "rgb(255, 255, 255)"
        assert not any(one.is_visible() for one in page.locator(".tools").all())
        page.pdf(path=output_folder / f"{any_page.parent.name}.pdf")
        assert (output_folder / f"{any_page.parent.name}.pdf").read_bytes().startswith(b"%PDF")


def test_pages_name_the_version(demo, any_page):
    version = actuator("--version").split()[1]
    assert f"actuator {version}</footer>" in any_page.read_text() and json.dumps(version)
