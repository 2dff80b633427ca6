"""Pages opened in headless Chromium: on a laptop and on a phone, in light and in dark mode."""

import shutil
from contextlib import contextmanager

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
SIZES = {"laptop": {"width": 1280, "height": 800}, "phone": {"width": 390, "height": 844}}
# Each size and each scheme once; the other two combinations with `./test --all`.
SCREENS = [
    ("laptop", "light"),
    ("phone", "dark"),
    pytest.param("laptop", "dark", marks=pytest.mark.slow),
    pytest.param("phone", "light", marks=pytest.mark.slow),
]
SMALLEST_PX = 10  # letters in a plot, as displayed on the screen
LEAST_CONTRAST = 4.5  # WCAG 2.2, success criterion 1.4.3
PATIENCE_MS = 20_000

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here (Debian: apt install chromium)")

# Contrast of all visible text against its background, and the smallest letters in plots.
LOOK = """() => {
  const channel = value => { const c = value / 255; return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4 };
  const colour = text => (text.match(/[\\d.]+/g) || [0, 0, 0, 0]).map(Number);
  const luminance = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const ground = element => {
    for (let e = element; e; e = e.parentElement) {
      const c = colour(getComputedStyle(e).backgroundColor);
      if (c.length === 3 || c[3] === 1) return c;
    }
    return [255, 255, 255];
  };
  let contrast = {least: 21, text: ''}, letters = {least: 100, text: ''};
  for (const element of document.querySelectorAll('body *')) {
    const text = [...element.childNodes].filter(n => n.nodeType === 3).map(n => n.data.trim()).join(' ').trim();
    if (!text || !element.getClientRects().length || ['TITLE', 'title', 'SCRIPT'].includes(element.tagName)) continue;
    const style = getComputedStyle(element), inPicture = element instanceof SVGElement;
    const [a, b] = [luminance(colour(inPicture ? style.fill : style.color)), luminance(ground(element))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < contrast.least) contrast = {least: ratio, text};
    if (inPicture) {
      const box = element.ownerSVGElement.getBoundingClientRect(), view = element.ownerSVGElement.viewBox.baseVal;
      const size = parseFloat(style.fontSize) * (view && view.width ? box.width / view.width : 1);
      if (size < letters.least) letters = {least: size, text};
    }
  }
  return {contrast, letters, overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
          pictures: document.querySelectorAll('svg').length, heading: document.querySelector('h1').innerText};
}"""


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        # Without these Chromium contacts hosts that a closed network does not have; as root it cannot use its sandbox.
        quiet = ["--no-sandbox", "--disable-background-networking", "--disable-component-update", "--disable-sync"]
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=quiet)
        yield browser
        browser.close()


@contextmanager
def opened(browser, path, size="laptop", scheme="light", **options):
    """The page, which must request no other file and write nothing to the console."""
    page = browser.new_page(viewport=SIZES[size], color_scheme=scheme, **options)
    said, asked = [], []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.goto(path.as_uri(), timeout=PATIENCE_MS)
    yield page
    page.close()
    assert not said, said
    assert asked == [path.as_uri()], "a page is one file and opens offline"


def assert_readable(page, pictures):
    """Nothing wider than the screen, legible text, at least so many plots."""
    seen = page.evaluate(LOOK)
    assert seen["overflow"] <= 0, f"the page is {seen['overflow']} px wider than the screen"
    assert seen["contrast"]["least"] >= LEAST_CONTRAST, seen["contrast"]
    assert seen["letters"]["least"] >= SMALLEST_PX, seen["letters"]
    assert seen["pictures"] >= pictures
