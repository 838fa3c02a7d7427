"""The book: its sources say true things, its built pages work without a network."""

import base64
import doctest
import json
import re
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import numpy as np
import pytest
from PIL import Image
from selenium.webdriver.common.keys import Keys

import kinlib
from browser import screen, wait_until
from kinlib.pictures import BLUE, VERMILION
from pages import EXPLORABLE, NOTEBOOKS, PAGES, ROOT, SCENES, TEXTS

FILES = ("CITATION.cff", "pyproject.toml", "README.md", "CONTRIBUTING.md", "book/assignments/pyproject.toml")


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def has_page(path: Path) -> bool:
    return Path(name_of(path)).with_suffix(".html").as_posix() in PAGES


def blocks(text: str, language: str) -> list[str]:
    """The code blocks of one language in a Markdown text."""
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


# ---- sources ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", TEXTS, ids=name_of)
def test_console_blocks_print_what_they_show(path):
    source = "\n".join(blocks(path.read_text(encoding="utf-8"), "pycon"))
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    runner.run(doctest.DocTestParser().get_doctest(source, {}, path.name, str(path), 0))
    assert runner.summarize(verbose=False).failed == 0


@pytest.mark.parametrize("path", TEXTS, ids=name_of)
def test_names_in_the_text_exist(path):
    owners = {
        "kl": kinlib,
        "q": kinlib.DualQuaternion,
        "C": kinlib.MotionPolynomial,
        "dyad": kinlib.Dyad,
        "space": kinlib.TwoRSpace,
        "linkage": kinlib.Linkage,
    }
    named = re.findall(rf"`({'|'.join(owners)})\.(\w+)", path.read_text(encoding="utf-8"))
    assert [(owner, name) for owner, name in named if name not in names_in(owners[owner])] == []


def names_in(owner) -> set[str]:
    """The attributes of a module or of a class, with those that every instance has."""
    return {*dir(owner), *getattr(owner, "__dataclass_fields__", ())}


def test_the_readme_prints_what_it_shows(capsys):
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (code,), (shown,) = blocks(text, "python"), blocks(text, "text")
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out == shown


@pytest.mark.parametrize("path", NOTEBOOKS, ids=name_of)
def test_notebooks_were_saved_after_one_clean_run(path):
    cells = [c for c in json.loads(path.read_text(encoding="utf-8"))["cells"] if c["cell_type"] == "code"]
    cells = [cell for cell in cells if "".join(cell["source"]).strip()]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [output for cell in cells for output in cell["outputs"]]
    assert [o for o in outputs if o["output_type"] == "error" or o.get("name") == "stderr"] == []


def address() -> str:
    """Where the project lives, as the configuration of the book says; nowhere yet if it says nothing."""
    found = re.search(
        r"^repository:[^#]*?\n  url: (\S+)", (ROOT / "_config.yml").read_text(encoding="utf-8"), re.MULTILINE
    )
    return found[1] if found else ""


@pytest.mark.parametrize("path", [*TEXTS, *NOTEBOOKS, *(ROOT / n for n in FILES)], ids=name_of)
def test_the_project_has_no_address_but_one(path):
    text = path.read_text(encoding="utf-8")
    ours = re.findall(r"https?://[^\s\"'<>)\\]*(?:kinlib|mybinder|colab\.research)[^\s\"'<>)\\]*", text)
    assert [url for url in ours if not address() or not url.startswith(address())] == []


# ---- built pages, as text --------------------------------------------------------------------------------


class Links(HTMLParser):
    """The targets that a page links to or loads, and the places in it that can be linked to."""

    def __init__(self, page: Path):
        super().__init__()
        self.targets, self.anchors = [], set()
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.anchors.update(values[key] for key in ("id", "name") if values.get(key))
        self.targets.extend(values[key] for key in ("href", "src") if values.get(key))


@pytest.fixture(scope="session")  # pages are visited one by one, by the tests of several files
def links(html) -> dict[Path, Links]:
    return {(html / page).resolve(): Links(html / page) for page in PAGES}


def is_broken(page: Path, target: str, links: dict[Path, Links]) -> bool:
    url = urlsplit(target)
    if url.scheme or url.netloc:
        return False
    file = (page.parent / unquote(url.path)).resolve() if url.path else page
    if file.is_dir() or not file.exists():
        return True
    return bool(url.fragment) and file in links and unquote(url.fragment) not in links[file].anchors


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(links, html, page):
    here = (html / page).resolve()
    assert [target for target in links[here].targets if is_broken(here, target, links)] == []


@pytest.mark.parametrize("path", [path for path in NOTEBOOKS if has_page(path)], ids=name_of)
def test_notebook_pages_offer_their_notebook(links, html, path):
    page = (html / name_of(path)).with_suffix(".html").resolve()
    (download,) = {target for target in links[page].targets if target.endswith(f"{path.name}")}
    assert (page.parent / download).read_bytes() == path.read_bytes()


@pytest.mark.parametrize("page", PAGES)
def test_pages_launch_nothing_without_an_address(links, html, page):
    targets = links[(html / page).resolve()].targets
    assert address() or not [target for target in targets if "binder" in target or "colab" in target]


CAPTION = re.compile(
    r'<figcaption>.*?<span class="caption-number">Fig\. [\d.]+ ?</span>.{20,}?</figcaption>', re.DOTALL
)


@pytest.mark.parametrize("name", [page for page in SCENES if "/release/" not in page])
def test_every_scene_has_a_still_a_number_and_a_caption(html, name):
    text = (html / name).read_text(encoding="utf-8")
    figures = [
        figure for figure in re.findall(r"<figure.*?</figure>", text, re.DOTALL) if 'class="kinlib-scene"' in figure
    ]
    assert len(figures) == text.count('class="kinlib-scene"') == text.count('class="kinlib-still"')
    assert [figure[:80] for figure in figures if not CAPTION.search(figure)] == []


def test_bars_of_docstrings_are_bars(html):
    text = (html / "book/api.html").read_text(encoding="utf-8")
    assert "|(b − a) · (l × k)| / |l × k|" in text  # in words
    assert '>"|"<' in text  # in code
    assert r"\|" not in text


@pytest.mark.parametrize("name", PAGES)
def test_every_caption_has_its_picture(html, name):
    figures = re.findall(r"<figure.*?</figure>", (html / name).read_text(encoding="utf-8"), re.DOTALL)
    assert [figure[:80] for figure in figures if not re.search("<(img|svg|iframe)", figure)] == []


@pytest.mark.parametrize("page", PAGES)
def test_pages_are_light(links, html, page):
    here = (html / page).resolve()
    images = {here.parent / target for target in links[here].targets if "_images/" in target}
    assert sum(file.stat().st_size for file in (here, *images)) <= 1_000_000


# ---- built pages, in a browser, from files, without a network --------------------------------------------

RAW_TEX = r"""
const root = document.querySelector("main") || document.body;
const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
const skip = "pre, code, script, style, mjx-container, textarea";
const found = [];
while (walker.nextNode()) {
  const { textContent, parentElement } = walker.currentNode;
  if (/\$|\\\(|\\\[|\\begin\{/.test(textContent) && !parentElement.closest(skip)) found.push(textContent);
}
return found;
"""


@pytest.mark.parametrize("name", PAGES)
def test_mathematics_is_set(look, name):
    driver = look(name)
    count = "return document.querySelectorAll(arguments[0]).length"
    formulas = driver.execute_script(count, ".math.notranslate, div.math")
    assert driver.execute_script(count, "mjx-container") >= formulas
    assert driver.execute_script(count, "mjx-merror, [data-mjx-error]") == 0
    assert driver.execute_script(RAW_TEX) == []


WIDER = """
const say = (box) => `${box.localName}.${box.className}: ${box.scrollWidth} > ${box.clientWidth}: `;
const boxes = "pre, .output, table, figure, img, dt, p, li, h1, h2, h3, div.math, mjx-container[display]";
return [...document.querySelectorAll("main :is(" + boxes + ")")].filter((box) =>
  box.clientWidth && box.scrollWidth > box.clientWidth + 1 && !(arguments[0] && box.closest(".scrolls, thead"))
).map((box) => say(box) + box.textContent.slice(0, 60));
"""


@pytest.mark.parametrize("name", PAGES)
def test_nothing_is_wider_than_its_box(look, name):
    """On a phone what is wider scrolls, and says so; the page does not."""
    driver = look(name)
    with screen(driver, 1400, 1000) as become:
        assert driver.execute_script(WIDER, False) == []
        become(390)
        driver.execute_async_script("requestAnimationFrame(() => requestAnimationFrame(arguments[0]))")
        assert driver.execute_script(WIDER, True) == []
        assert driver.execute_script("return document.documentElement.scrollWidth") <= 390


def printed(driver, folder: Path) -> list[np.ndarray]:
    """The sheets that the page's own button prints, as pixels, and their text beside them."""
    sheets = driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": False})
    folder.joinpath("page.pdf").write_bytes(base64.b64decode(sheets["data"]))
    for program in (["pdftoppm", "-r", "60", "page.pdf", "sheet"], ["pdftotext", "-layout", "page.pdf", "page.txt"]):
        subprocess.run(program, cwd=folder, check=True)
    return [np.asarray(Image.open(path).convert("RGB"), dtype=int) for path in sorted(folder.glob("sheet*.ppm"))]


def ink(sheet: np.ndarray, colour: str) -> int:
    """How many pixels of a sheet have a colour, nearly."""
    wanted = [int(colour[n : n + 2], 16) for n in (1, 3, 5)]
    return int((np.abs(sheet - wanted).max(axis=-1) < 24).sum())


@pytest.mark.parametrize("name", ["book/dyads/two_r_dyads.html", "book/synthesis/three_poses.html"])
def test_pages_are_printed_with_their_scenes_and_all_of_their_code(page, tmp_path, name):
    driver = page(name)
    sheets = printed(driver, tmp_path)
    scenes = driver.find_elements("css selector", "iframe.kinlib-scene")
    assert len([sheet for sheet in sheets if ink(sheet, VERMILION) > 150 and ink(sheet, BLUE) > 150]) >= len(scenes)
    assert all((sheet[:, -20:] > 250).all() and (sheet[:, :20] > 250).all() for sheet in sheets)
    text = "".join((tmp_path / "page.txt").read_text(encoding="utf-8").split())
    code = [code.text for code in driver.find_elements("css selector", "div.highlight pre") if code.is_displayed()]
    assert code
    assert [line for block in code for line in block.splitlines() if "".join(line.split()) not in text] == []
    assert "Resettheview" not in text


def test_search_finds_what_a_reader_types(page):
    driver = page("book/index.html")
    driver.find_element("css selector", ".search-button").click()
    driver.find_element("css selector", "#pst-search-dialog input").send_keys("Goldberg", Keys.ENTER)
    results = "return [...document.querySelectorAll('#search-results li a')].map(({ pathname }) => pathname)"
    found = wait_until(lambda: driver.execute_script(results))
    assert [path for path in found if path.endswith("book/synthesis/goldberg_5r.html")]


MOVE_SLIDER = """
const slider = document.querySelector("input[type=range]");
slider.value = arguments[0];
slider.dispatchEvent(new Event("input"));
"""


@pytest.mark.parametrize("name", PAGES)
def test_pages_have_their_scenes(html, name):
    text = (html / name).read_text(encoding="utf-8")
    figures = re.findall(r'<figure [^>]*?id="([^"]+)">(?:(?!</figure>).)*?class="kinlib-scene"', text, re.DOTALL)
    assert figures == SCENES.get(name, [])
    assert text.count('class="kinlib-scene"') == len(figures)


@pytest.mark.parametrize("name", SCENES)
def test_scenes_play_and_obey(page, name):
    driver = page(name)
    frames = driver.find_elements("css selector", "iframe.kinlib-scene")
    assert len(frames) == len(SCENES[name])
    for figure, frame in zip(SCENES[name], frames, strict=True):
        driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", frame)
        driver.switch_to.frame(frame)
        plays_and_obeys(driver)
        assert driver.execute_script("return !!kinlib.parameters") == (figure in EXPLORABLE)
        driver.switch_to.default_content()


def follows_its_controls(driver):
    """Check the scene with parameters in the current frame: a key on each control changes what is seen."""
    from selenium.webdriver.common.keys import Keys

    ask = driver.execute_script
    ask("kinlib.pause()")
    for control in driver.find_elements("css selector", ".pad, .slide input"):
        before = ask("return kinlib.points()")
        control.send_keys(Keys.ARROW_RIGHT)
        assert ask("return kinlib.points()") != before
        assert control.get_attribute("aria-valuetext")
    for button in driver.find_elements("css selector", ".move"):
        before = ask("return kinlib.points()")
        button.send_keys(Keys.ENTER)
        assert ask("return kinlib.points()") != before
    ask("kinlib.play()")


def plays_and_obeys(driver):
    """Check the scene in the current frame: it is drawn, moves by itself, stops, and follows its slider."""
    ask = driver.execute_script
    wait_until(lambda: ask("return !!(window.kinlib && kinlib.ready)"))
    if ask("return !!kinlib.parameters"):
        follows_its_controls(driver)
    frames = ask("return kinlib.frames")
    if frames < 2:
        return
    start = ask("return kinlib.frame")
    wait_until(lambda: ask("return kinlib.frame") != start)

    button, stage = (driver.find_element("css selector", css) for css in (".controls button", ".stage"))
    button.click()
    assert not ask("return kinlib.playing")
    stop, seen = ask("return kinlib.frame"), stage.screenshot_as_png
    assert ask("return kinlib.frame") == stop

    target = round(stop + frames / 3) % frames
    ask(MOVE_SLIDER, target)
    assert ask("return kinlib.frame") == target
    assert stage.screenshot_as_png != seen

    button.click()
    wait_until(lambda: ask("return kinlib.frame") != target)
