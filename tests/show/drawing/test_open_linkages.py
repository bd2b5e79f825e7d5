"""A linkage that cannot be assembled is drawn as far as it goes, with its gap."""

from cmath import rect
from math import radians

import pytest

from camopt import BadInput, find_scene
from camopt.cli.main import main
from camopt.show.drawing.linkage import draw_stage_of_refused_scene

FOUR_BAR, SLIDE = "press-ram-by-four-bar", "slide-by-bell-crank"


def refusal(name, changes):
    with pytest.raises(BadInput) as refused:
        find_scene(name).replace(**changes)
    return refused.value


def legend(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


@pytest.mark.parametrize(
    ("ground", "coupler", "rocker"), [(400.0, 200.0, 100.0), (220.0, 300.0, 40.0), (220.0, 40.0, 300.0)]
)
def test_the_gap_of_a_four_bar_is_between_the_circles(ground, coupler, rocker):
    keys = {"train.1.ground": ground, "train.1.coupler": coupler, "train.1.rocker": rocker}
    figure = draw_stage_of_refused_scene(refusal(FOUR_BAR, keys))
    apart = abs(ground - rect(110.0, radians(70.0)))
    gap = max(apart - coupler - rocker, abs(coupler - rocker) - apart)
    assert gap > 0.0
    assert legend(figure) == ["reach of the coupler", "reach of the rocker", f"gap {gap:.4g} mm"]
    (line,) = [line for line in figure.axes[0].lines if line.get_label().startswith("gap")]
    ends = line.get_xdata() + 1j * line.get_ydata()
    assert abs(ends[1] - ends[0]) == pytest.approx(gap, rel=1e-12)
    assert abs(ends[0] - rect(110.0, radians(70.0))) == pytest.approx(coupler, rel=1e-12)
    assert abs(ends[1] - ground) == pytest.approx(rocker, rel=1e-12)


@pytest.mark.parametrize(("offset", "sign"), [(120.0, 1.0), (-400.0, -1.0)])
def test_the_gap_of_a_slide_and_the_senses_of_offset_and_angle(offset, sign):
    figure = draw_stage_of_refused_scene(refusal(SLIDE, {"train.1.offset": offset}))
    gap = abs(offset - rect(160.0, radians(-110.0)).imag) - 220.0
    assert legend(figure) == ["reach of the coupler", "line of the slide", f"gap {gap:.4g} mm"]
    (slide,) = [line for line in figure.axes[0].lines if line.get_label() == "line of the slide"]
    assert set(slide.get_ydata()) == {offset}  # above the pivot where it is positive
    texts = {text.get_text().strip() for text in (*figure.texts, *figure.axes[0].texts)}
    assert {"+ angle", "+ offset", "angle −110°", f"offset {'' if sign > 0 else '−'}{abs(offset):g} mm"} <= texts
    assert "the coupler (220 mm) does not reach the slide: it is" in " ".join(texts)


def test_a_stage_that_reaches_a_dead_point_is_drawn_there():
    figure = draw_stage_of_refused_scene(refusal(SLIDE, {"motion.1.lift": 400, "motion.3.lift": 400}))
    assert legend(figure) == [
        "dead point: the coupler is square to the slide",
        "dead point: crank and coupler are in line",
    ]
    (line,) = [line for line in figure.axes[0].lines if line.get_label().endswith("in line")]
    points = line.get_xdata() + 1j * line.get_ydata()
    assert abs(points[~(points != points)]).max() == pytest.approx(
        380.0, rel=1e-9
    )  # crank and coupler, from the pivot


@pytest.mark.parametrize(
    "changes",
    [{"train.1.stage": "rocker"}, {"cam.base_radius": -1}, {"train.1.angle": None}, {"train.1.crank": "long"}],
)
def test_other_mistakes_have_no_picture(changes, tmp_path):
    assert draw_stage_of_refused_scene(refusal(SLIDE, changes), tmp_path / "cam.svg") is None
    assert not (tmp_path / "cam.svg").exists()


@pytest.mark.parametrize("words", [["plot", SLIDE], ["evaluate", SLIDE, "--plot"]])
def test_commands_write_the_picture_with_the_message(words, tmp_path, capsys):
    path = tmp_path / "why.svg"
    assert main([*words, str(path), "--set", "train.1.offset=120"]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"camopt: {path} shows the linkage as far as it goes\n")
    assert "does not reach the slide" in told
    assert "gap 50.35 mm" in path.read_text(encoding="utf-8")
