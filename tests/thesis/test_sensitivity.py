"""The study of open choices: its design, its margins, its rule, and that its runs are those of the scenarios."""

from __future__ import annotations

import csv
import itertools
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim.assessment import Counts, score
from cosim.cli import main
from cosim.fmu import catalogue
from cosim.thesis import Reproduction, Sensitivity, sensitivity
from cosim.thesis._runs import SAMPLE_TIMES, scenario_run
from cosim.thesis._sensitivity import Study, columns, write_runs
from cosim.thesis._sensitivity_design import Case, alone, factorial, interactions, signs, together
from cosim.thesis._sensitivity_effects import effects
from cosim.thesis._sensitivity_factors import ASSUMED, DISTURBANCE, FACTORS, SAMPLED, SLOW, Bench, Setting, relevant
from cosim.thesis._sensitivity_page import conclusion, drift_law, page
from cosim.thesis._sensitivity_picture import draw
from cosim.thesis._sensitivity_runs import (
    LOADS,
    READINGS,
    Outcome,
    Passed,
    Table,
    judge,
    outcome,
    passed,
    run,
    run_tables,
)
from cosim.thesis._sensitivity_verdict import Verdict, judge_table, late_of, verdict
from cosim.thesis._table import PUBLISHED

pytest.importorskip("rumoca")

ROOT = Path(__file__).parents[2]
SCENARIOS = ROOT / "scenarios"
SEPARATE = READINGS[4].rules
WHOLE_RAMP = {**ASSUMED, "soft_stop": 1.0}
ONE_RATE = {**ASSUMED, "chart": SLOW, "measuring": SLOW}
NOISY = {**ASSUMED, "chart": SLOW, "noise_A": 0.2, "T_ramp_s": 0.08, "n_window": 25.0, "J_rotor_kgm2": 2e-4}


@pytest.fixture(scope="module")
def bench() -> Bench:
    return Bench.load(SCENARIOS, catalogue.ensure)


def test_the_fraction_is_balanced_and_orthogonal() -> None:
    matrix = signs()
    assert matrix.shape == (64, len(FACTORS))
    assert np.array_equal(matrix.sum(axis=0), np.zeros(11))
    assert np.array_equal(matrix.T @ matrix, 64 * np.eye(11))
    for factor, column in zip(FACTORS, matrix.T, strict=True):
        levels = [case.setting[factor.key] for case in factorial()]
        assert [factor.high if sign > 0 else factor.low for sign in column] == levels


def test_no_main_effect_is_mixed_up_with_an_interaction() -> None:
    """Resolution IV; and no interaction of the chart's rate is mixed up with any other."""
    matrix = signs()
    for a, b in itertools.combinations(range(11), 2):
        assert not np.any(matrix.T @ (matrix[:, a] * matrix[:, b]))
    chart = [factor.key for factor in FACTORS].index("chart")
    assert all(same == [pair] for pair, same in interactions().items() if chart in pair)


def test_each_choice_is_changed_alone_to_each_of_its_levels() -> None:
    changed = [{key for key in ASSUMED if case.setting[key] != ASSUMED[key]} for case in alone()]
    assert changed == [set(), *({factor.key} for factor in FACTORS for _ in factor.others)]
    assert len({tuple(case.setting.values()) for case in alone()}) == len(alone())


@pytest.mark.parametrize(("sample_time", "load"), [(0.001, "normal"), (0.02, "disturbed"), (0.05, "disturbed")])
def test_the_assumed_setting_is_that_of_the_scenarios(bench: Bench, sample_time: float, load: str) -> None:
    """Its counts are those of ``cosim score`` on the shipped file, which another controller simulates for longer."""
    ending = "" if load == "normal" else "_disturbed"
    result = scenario_run(SCENARIOS / f"rig_{1e3 * sample_time:.0f}ms{ending}.csv", catalogue.ensure)
    found = outcome(bench, ASSUMED, sample_time, load)
    for reading in READINGS:
        counts = score(result, reading.rules).counts
        assert found.passed[reading.key] == passed_by(counts, reading.literal)
        assert found.total == counts.park_total == counts.turn_total


def passed_by(counts: Counts, literal: bool) -> Passed:
    return Passed(counts.park_literal if literal else counts.park_deceleration, counts.turn)


@pytest.mark.parametrize("setting", [ONE_RATE, {**ONE_RATE, "park": SAMPLED}, WHOLE_RAMP, NOISY])
def test_one_scoring_counts_as_the_scorer_does_by_each_reading(bench: Bench, setting: Setting) -> None:
    result = run(bench, setting, 0.02, "disturbed")
    scored = score(result, SEPARATE)
    for reading in READINGS:
        assert passed(scored, reading) == passed_by(score(result, reading.rules).counts, reading.literal)


def test_what_no_run_depends_on_changes_none(bench: Bench) -> None:
    """Nothing but the setting differs, so that every number must be the same: the reason why one run stands for all."""
    pulses = {**ASSUMED, "pulse_size_Nm": 20.0, "pulse_phase_s": 1.5}
    latch = {**ASSUMED, "park": SAMPLED}
    for other, sample_time, load in [
        (pulses, 0.02, "normal"), (latch, 0.02, "disturbed"), (ONE_RATE, 0.001, "normal"),
        ({**ONE_RATE, "park": SAMPLED}, 0.001, "disturbed"),
    ]:  # fmt: skip
        assert relevant(other, sample_time, load) == relevant(ASSUMED, sample_time, load)
        first, second = (run(bench, setting, sample_time, load, 8.0).columns for setting in (ASSUMED, other))
        assert all(np.array_equal(first[name], second[name]) for name in first)


def test_every_other_choice_changes_a_run(bench: Bench) -> None:
    reference = run(bench, ASSUMED, 0.02, "disturbed", 8.0).columns
    for case in alone()[1:]:
        if case.setting["park"] == SAMPLED:
            continue
        changed = run(bench, case.setting, 0.02, "disturbed", 8.0).columns
        assert any(not np.array_equal(changed[name], reference[name]) for name in reference), case.name
        assert relevant(case.setting, 0.02, "disturbed") != relevant(ASSUMED, 0.02, "disturbed")
    assert frozenset(ASSUMED) > DISTURBANCE


@pytest.mark.parametrize("setting", [ASSUMED, ONE_RATE, WHOLE_RAMP, NOISY])
@pytest.mark.parametrize("sample_time", [0.01, 0.05])
def test_the_plan_is_what_the_scorer_sees(bench: Bench, setting: Setting, sample_time: float) -> None:
    """It ended so long before the signal, lasted through it, or had not begun."""
    result = run(bench, setting, sample_time, "normal")
    revolutions = score(result, SEPARATE).revolutions[1:]
    leads = judge(result, setting, sample_time).leads
    tick = sample_time if setting["chart"] == SLOW else 0.001
    length = tick * np.ceil(float(setting["soft_stop"]) * float(setting["T_ramp_s"]) / tick - 1e-9)
    assert len(leads) == len(revolutions) >= 7
    for revolution, lead in zip(revolutions, leads, strict=True):
        if lead > 1e-6:
            assert revolution.ended_before == pytest.approx(lead, abs=1e-9)
        assert revolution.park_deceleration == (-length + 1e-6 < lead < 1e-6)


@pytest.mark.parametrize(
    ("setting", "law"), [(ASSUMED, 0.049), (WHOLE_RAMP, -0.001), ({**ASSUMED, "soft_stop": 0.75}, 0.024)]
)
def test_the_deceleration_drifts_as_figure_3_11_makes_it(bench: Bench, setting: Setting, law: float) -> None:
    """The law takes revolutions to be alike; they differ by some milliseconds, as the profile moves along them."""
    assert drift_law(setting, 0.02) == pytest.approx(law, abs=1e-9)
    assert outcome(bench, setting, 0.02, "normal").drift == pytest.approx(law, abs=0.004)


def test_the_tick_of_the_chart_drifts_too(bench: Bench) -> None:
    for sample_time, law in ((0.01, 0.04), (0.02, 0.02), (0.05, 0.0)):
        assert drift_law(ONE_RATE, sample_time) == pytest.approx(law, abs=1e-9)
        # the chart measures the period in half ticks
        assert outcome(bench, ONE_RATE, sample_time, "normal").drift == pytest.approx(law, abs=sample_time / 2)


def test_the_rule_finds_the_source_s_conclusion_in_its_own_table() -> None:
    counts = dict.fromkeys(SAMPLE_TIMES, (0, 0))
    for (time, _), texts in PUBLISHED.items():
        for right, of in (map(int, text.split("/")) for text in texts):
            counts[time] = (counts[time][0] + right, counts[time][1] + of)
    assert verdict(counts, {0.05}) is Verdict.BEST
    assert verdict(counts, {}) is Verdict.LONGER
    assert verdict(counts, {0.02, 0.05}) is Verdict.LATE


@pytest.mark.parametrize(
    ("others", "found"),
    [
        ((10, 10, 10, 10), Verdict.BEST), ((10, 10, 19, 10), Verdict.SHARED), ((20, 20, 21, 20), Verdict.SAME),
        ((20, 22, 20, 20), Verdict.SHORTER), ((10, 10, 10, 30), Verdict.LONGER), ((30, 0, 0, 31), Verdict.LONGER),
    ],
)  # fmt: skip
def test_one_prediction_more_is_not_better_yet(others: tuple[int, ...], found: Verdict) -> None:
    times = (0.001, 0.002, 0.010, 0.050)
    counts = {time: (number, 40) for time, number in zip(times, others, strict=True)} | {0.020: (20, 40)}
    assert verdict(counts, set()) is found


def test_effects_of_a_known_response_are_found() -> None:
    matrix = signs()
    chart, stop = 7, 2
    y = 5 + 1.5 * matrix[:, 4] - 0.5 * matrix[:, chart] * matrix[:, stop]
    found = effects(y)
    expected = np.zeros(11)
    expected[4] = 3.0
    assert found.main == pytest.approx(expected, abs=1e-12)
    assert found.pairs[stop, chart] == pytest.approx(-1.0)
    assert sum(abs(v) > 1e-12 for v in found.pairs.values()) == 1
    assert found.main_share[4] == found.share[4] == pytest.approx(1.5**2 / (1.5**2 + 0.5**2))
    assert found.share[chart] == found.share[stop] == pytest.approx(0.5**2 / (1.5**2 + 0.5**2))
    assert found.margin < 1e-12
    constant = effects(np.full(64, 2.0))
    assert not constant.main.any()
    assert not constant.share.any()


def test_scatter_stays_below_its_margin() -> None:
    """Of contrasts that are nothing but scatter one in twenty passes it, by its definition."""
    random = np.random.default_rng(1)
    beyond = [np.abs(found.main) > found.margin for found in (effects(random.normal(size=64)) for _ in range(200))]
    assert np.mean(beyond) == pytest.approx(0.05, abs=0.02)


def fabricated(shares: Mapping[float, tuple[int, int]], answers: Mapping[float, int] | None = None) -> Study:
    """A study with the same counts of parks and turns out of ten by all readings, under all settings."""
    late = answers or {}

    def made(time: float, setting: Setting) -> Outcome:
        counts = {reading.key: Passed(*shares[time]) for reading in READINGS}
        lead = 0.02 * float(setting["soft_stop"])
        return Outcome(counts, 10, late.get(time, 0), (lead, lead), 0.01, (30.0, 32.0), 0.4)

    return Study(
        tuple(
            Table(case, {(time, load): made(time, case.setting) for time in SAMPLE_TIMES for load in LOADS})
            for case in (*alone(), *together(), *factorial())
        )
    )


def test_the_margins_are_those_of_the_runs() -> None:
    """Here the lead is 20 ms times the Soft_stop, which is 0.5 or 1, and everything else the same."""
    margins = fabricated(dict.fromkeys(SAMPLE_TIMES, (8, 9))).margins
    stop = [factor.key for factor in FACTORS].index("soft_stop")
    expected = np.zeros(11)
    expected[stop] = 10.0
    found = list(margins.values())
    assert found[0].main == pytest.approx(expected, abs=1e-9)
    for other in found[1:]:
        assert other.main == pytest.approx(np.zeros(11), abs=1e-9)


def test_the_page_says_what_the_rule_finds(tmp_path: Path) -> None:
    best = fabricated({0.001: (5, 6), 0.002: (5, 6), 0.01: (7, 6), 0.02: (9, 6), 0.05: (9, 9)}, {0.05: 6})
    assert best.all_verdicts == {Verdict.BEST: 64 * len(READINGS)}
    assert late_of(best.tables[0]) == {0.05}
    assert "20 ms is the best sampling time stands over" in conclusion(best)
    same = fabricated(dict.fromkeys(SAMPLE_TIMES, (8, 9)))
    assert "20 ms is the best sampling time does not stand" in conclusion(same)
    assert "100 % that all sampling times are as good" in conclusion(same)
    text = page(best, "x/y.png")
    assert "](x/y.png)" in text
    assert "nan" not in text
    draw(best, tmp_path / "sensitivity.png")
    assert (tmp_path / "sensitivity.png").read_bytes().startswith(b"\x89PNG")


def test_the_table_has_every_run(tmp_path: Path, bench: Bench) -> None:
    cases = [alone()[0], replace(together()[0], name="one rate")]
    tables = run_tables(bench, cases)
    assert tables == run_tables(bench, cases)
    write_runs(tables, tmp_path / "runs.csv")
    with (tmp_path / "runs.csv").open(encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(file))
    assert list(lines[0]) == columns()
    cells = [(case.name, time, load) for case in cases for time in SAMPLE_TIMES for load in LOADS]
    assert [(line["case"], float(line["sample_time_s"]), line["load"]) for line in lines] == cells
    first = tables[0].outcomes[0.001, "normal"]
    assert int(lines[0]["park_dip"]) == first.passed["dip"].park
    assert float(lines[0]["lead_mean_ms"]) == pytest.approx(1e3 * np.mean(first.leads), abs=1e-4)
    assert lines[0]["soft_stop"] == str(ASSUMED["soft_stop"])


def test_a_case_without_turns_has_a_verdict(bench: Bench) -> None:
    """A chart of 50 ms that samples the contact misses most of it: counts, but hardly a margin."""
    setting = {**ONE_RATE, "park": SAMPLED, "n_window": 25.0}
    (table,) = run_tables(bench, [Case("missed", "alone", setting)])
    assert all(isinstance(judge_table(table, reading), Verdict) for reading in READINGS)


def test_the_command_varies_when_it_is_asked_to(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import cosim.cli._thesis as command

    def made(out: Path, *_: object, sensitive: bool, **__: object) -> Reproduction:
        varied = Sensitivity((out / "sensitivity.md",), "**It stands.**", "**What decides** is x.")
        return Reproduction((), (), (), varied if sensitive else None)

    monkeypatch.setattr(command, "reproduce", made)
    for options, text in (([], ""), (["--sensitivity"], "\nIt stands.\n\nWhat decides is x.\n")):
        with pytest.raises(SystemExit) as left:
            main(["thesis", *options])
        assert (left.value.code, capsys.readouterr().out) == (0, text)


@pytest.mark.slow
def test_the_documentation_is_what_the_command_makes(tmp_path: Path) -> None:
    made = sensitivity(tmp_path, SCENARIOS, catalogue.ensure, picture="pictures/sensitivity.png")
    assert made.files[2].read_text(encoding="utf-8") == (ROOT / "docs/sensitivity.md").read_text(encoding="utf-8")
    rows: list[dict[str, Any]] = list(csv.DictReader(made.files[0].read_text(encoding="utf-8").splitlines()))
    assert len(rows) == 10 * len([*alone(), *together(), *factorial()])
