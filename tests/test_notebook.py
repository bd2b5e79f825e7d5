"""What results show of themselves: a line of text, a table with units and limits; names that are nearly right."""

import pickle
from html.parser import HTMLParser

import pytest

from camopt import evaluate, find_scene, optimise, sweep

NAME = "a < b & c"
SCENE = find_scene("two-pauses").replace(name=NAME, search={"base_radius": [60, 70]}, limits={"pressure_angle": 30})


class Tags(HTMLParser):
    """The texts of a page, and whether each tag is closed."""

    def __init__(self, page):
        super().__init__()
        self.open, self.texts = [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.open += [tag] if tag != "br" else []

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


@pytest.fixture(scope="module")
def results():
    best, swept = optimise(SCENE), sweep(SCENE)
    return {"Scene": SCENE, "Evaluation": evaluate(SCENE), "Optimum": best, "Design": best.best, "Sweep": swept}


@pytest.mark.parametrize("kind", ["Scene", "Evaluation", "Optimum", "Design", "Sweep"])
def test_results_show_themselves_in_a_line_and_as_html(results, kind):
    shown = repr(results[kind])
    assert shown.startswith(f"<{kind} ")
    assert NAME in shown
    assert len(shown) < 160
    page = Tags(results[kind]._repr_html_())
    assert not page.open
    assert any(NAME in text for text in page.texts)
    if kind != "Scene":
        assert {"≤ 30", "deg", "mm"} <= {*page.texts}


def test_designs_travel_between_processes(results):
    design = pickle.loads(pickle.dumps(results["Design"]))
    assert design == results["Design"]
    assert design.scene == results["Design"].scene


@pytest.mark.parametrize("kind", ["Evaluation", "Design"])
def test_a_name_that_is_nearly_right_is_answered_by_the_nearest(results, kind):
    found = results[kind]
    assert "presure_angle_max_deg" not in found
    assert found.get("presure_angle_max_deg") is None
    with pytest.raises(KeyError, match="did you mean pressure_angle_max_deg"):
        found["presure_angle_max_deg"]
