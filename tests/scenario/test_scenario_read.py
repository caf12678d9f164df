"""Scenario files: what is read, and the full message for everything that is refused before the FMUs are looked at."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.errors import InputError
from cosim.scenario import Column, Link, Setting, read
from cosim.units import parse

HEAD = "# system: linkage\n# controller: none\n# stop: 2 s\n"


def write(folder: Path, text: str | bytes) -> Path:
    path = folder / "x.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def refusal(folder: Path, text: str | bytes, *settings: str) -> str:
    with pytest.raises(InputError) as error:
        read(write(folder, text), settings)
    assert error.value.exit_code == 2
    return str(error.value).removeprefix(f"{folder / 'x.csv'}:").strip()


def test_a_whole_file(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        "# title: Everything at once\n"
        "## shows: a comment may have a colon after two number signs\n"
        "# and needs none without\n"
        "#\n"
        "# system: linkage\n"
        "# controller: voltage_profile\n"
        "# stop: 0.5 min\n"
        "# sample_time: 50 ms\n"
        "# output_interval: 2 ms\n"
        "# tolerance: 1e-7\n"
        "# set: plant.ext_load = 4 N.m\n"
        "# set: J_rotor = 1e-4 kg.m2\n"
        "# map: plant.tau_crank -> controller.torque\n"
        "# linear: v_supply\n"
        "time [ms],v_supply [V],plant.tau_disturbance [N.m],enable\n"
        "0,28,,1\n"
        "1000,24,,\n"
        "1000,26,-5,0\n"
        "\n"
        "1500.5,,0,\n",
    )
    scenario = read(path)
    assert (scenario.path, scenario.title) == (path, "Everything at once")
    assert (scenario.system, scenario.controller) == ("linkage", "voltage_profile")
    assert (scenario.stop, scenario.sample_time, scenario.output_interval) == (30.0, 0.05, 0.002)
    assert scenario.tolerance == 1e-7
    assert scenario.settings == (
        Setting("plant.ext_load", "4 N.m", path, 11),
        Setting("J_rotor", "1e-4 kg.m2", path, 12),
    )
    assert scenario.links == (Link(("plant", "tau_crank"), ("controller", "torque"), 13),)
    assert scenario.columns == (
        Column("v_supply", parse("V"), 2, 15, (0.0, 1.0, 1.0), (28, 24, 26), (16, 17, 18), linear=True),
        Column("plant.tau_disturbance", parse("N.m"), 3, 15, (1.0, 1.5005), (-5, 0), (18, 20)),
        Column("enable", None, 4, 15, (0.0, 1.0), (1, 0), (16, 18)),
    )
    assert scenario.key_lines["sample_time"] == 8


def test_what_may_be_left_out(tmp_path: Path) -> None:
    scenario = read(write(tmp_path, "# system: rig\n# controller: none\ntime [s],duty [1]\n0,0\n0,1\n25,\n"))
    assert (scenario.stop, scenario.sample_time) == (25.0, 0.02)
    assert (scenario.output_interval, scenario.tolerance, scenario.title) == (0.001, 1e-6, "")
    assert scenario.controller is None
    assert scenario.columns[0].times == (0.0, 0.0)


@pytest.mark.parametrize("rows", ["", "0\n", "0\n1\n"])
def test_without_channels_the_header_is_enough(tmp_path: Path, rows: str) -> None:
    assert read(write(tmp_path, HEAD + "time [s]\n" + rows)).columns == ()


@pytest.mark.parametrize(
    "text",
    [
        "# system: linkage;;\r\n# controller: none;;\r\n# stop: 2,5 s;;\r\n"
        "time [s];duty [1];\r\n0;0,5;\r\n2,5;1;\r\n;;\r\n",
        '\ufeff"# system: linkage"\n"# controller: none"\n# stop: 2.5 s\n"time [s]","duty [1]"\n"0","0.5"\n"2.5","1"\n',
        "# system: linkage\t\t\n# controller: none\t\n# stop: 2500 ms\ntime [s]\tduty [1]\n0\t0.5\n2.5\t1\n",
        "# system: linkage,,\r# controller: none,,\r# stop: 2.5 s,,\rtime [s],duty [1],\r0,.5,\r2.5,1e0,\r,,\r",
    ],
    ids=["semicolon and decimal comma", "BOM and quotes", "tab", "old line ends and separators"],
)
def test_what_spreadsheets_write(tmp_path: Path, text: str) -> None:
    scenario = read(write(tmp_path, text))
    assert (scenario.system, scenario.controller, scenario.stop) == ("linkage", None, 2.5)
    assert [(c.name, c.times, c.values) for c in scenario.columns] == [("duty", (0, 2.5), (0.5, 1))]


def test_a_title_keeps_its_comma(tmp_path: Path) -> None:
    text = '"# title: dry glass, cold motor",,\n' + HEAD + "time [s],duty [1],x [1]\n0,1,1\n"
    assert read(write(tmp_path, text)).title == "dry glass, cold motor"


def test_an_element_of_an_array_is_no_unit(tmp_path: Path) -> None:
    columns = read(write(tmp_path, HEAD + "time [s],x[1],x[2] [V],y[ms]\n0,1,1,1\n")).columns
    assert [(column.name, column.unit) for column in columns] == [
        ("x[1]", None),
        ("x[2]", parse("V")),
        ("y", parse("ms")),
    ]


def test_instants_within_a_nanosecond_are_one(tmp_path: Path) -> None:
    scenario = read(write(tmp_path, HEAD + "time [s],duty [1]\n0,0\n1,0\n1.0000000005,1\n"))
    assert scenario.columns[0].times == (0.0, 1.0, 1.0)


def test_options_win_over_the_file(tmp_path: Path) -> None:
    path = write(tmp_path, HEAD + "# set: plant.ext_load = 4 N.m\ntime [s]\n")
    scenario = read(path, ["stop=500 ms", "plant.ext_load = 5 N.m", "sample_time=1 ms", "sample_time=2 ms"])
    assert (scenario.stop, scenario.sample_time) == (0.5, 0.002)
    assert scenario.settings == (Setting("plant.ext_load", "5 N.m", "--set"),)


KEYS = (
    "keys are title, system, controller, stop, sample_time, output_interval, macro_step, tolerance, algorithm, "
    "extrapolation, set, map, linear, fault, power"
)
UNITS = (
    "accepted are SI symbols with prefixes and bare exponents, joined by '.' and '/', such as "
    "N.m, kg.m2, rad/s, V.s/rad, m/s2, Ohm, ms, deg, rpm, degC, % or 1 for a plain number"
)
NOT_A_NUMBER = (
    "is not a number; accepted are finite numbers such as 12, -0.5 or 3e-2, and an empty cell for 'unchanged'"
)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (
            "# smaple_time: 20 ms",
            f"1: unknown key 'smaple_time', did you mean 'sample_time'?; {KEYS}; "
            "a comment that has a ':' starts with '##'",
        ),
        ("# stop = 2 s", "1: 'stop = 2 s' has no ':'; write '# stop: value', or '##' in front of a comment"),
        ("# stpo=2 s", "1: 'stpo=2 s' has no ':'; write '# key: value', or '##' in front of a comment"),
        ("# stop:", "1: 'stop' has no value; write a time such as 25 s"),
        (
            "# system:",
            "1: 'system' has no value; write a built-in plant such as linkage, or the path of an .fmu, .ssp or .ssd",
        ),
        ("# sample_time: 20", "1: 'sample_time' is a time, '20' is not; write 20 s or 20 ms"),
        ("# sample_time: 20 mV", "1: 'sample_time' is a time, '20 mV' is not; write a time such as 20 ms"),
        ("# sample_time: -1 ms", "1: 'sample_time' must be longer than 0 s, found '-1 ms'"),
        (
            "# sample_time: fast",
            "1: 'sample_time': 'fast' is not a number with a unit; write it like 20 ms or 4.5 N.m; "
            "write a time such as 20 ms",
        ),
        ("# sample_time: 1 sec_", f"1: 'sample_time': 'sec_' is not a unit; {UNITS}; write a time such as 20 ms"),
        (
            "# tolerance: 1e-6 s",
            "1: 'tolerance' must be a number between 0 and 1 without a unit, found '1e-6 s'; write 1e-6",
        ),
        (
            "# tolerance: 1e-13",
            "1: 'tolerance' is 1e-13; below 1e-12 rounding errors count for more than those of the method; "
            "write 1e-12 or more",
        ),
        ("# tolerance: 0", "1: 'tolerance' must be a number between 0 and 1 without a unit, found '0'; write 1e-6"),
        (
            "# set: plant.ext_load 4 N.m",
            "1: 'plant.ext_load 4 N.m' is not 'name = value'; write for example 'plant.ext_load = 4 N.m'",
        ),
        (
            "# map: plant.a controller.b",
            "1: 'plant.a controller.b' is not a connection; write 'map: component.output -> component.input', "
            "for example 'map: plant.i_motor -> controller.current'",
        ),
        ("# linear: dutty", "1: 'linear' names 'dutty', did you mean 'duty'?; the columns are duty"),
        ("# output_interval: 3 s", "1: 'output_interval' 3.0 s is longer than the run, which stops at 2.0 s"),
    ],
)
def test_key_lines_that_are_refused(tmp_path: Path, line: str, message: str) -> None:
    assert refusal(tmp_path, f"{line}\n{HEAD}time [s],duty [1]\n0,1\n") == message


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("# stop: 2 s", "4: 'stop' is given a second time, first in line 3; it can be given once"),
        ("# set: a = 1\n# set: a = 2", "5: 'a' is set a second time, first in line 4"),
    ],
)
def test_keys_given_twice(tmp_path: Path, line: str, message: str) -> None:
    assert refusal(tmp_path, f"{HEAD}{line}\ntime [s],duty [1]\n0,1\n") == message


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("", "no header line below the '#' lines; expected a header such as 'time [s],duty [1]' and rows below it"),
        ("0,1\n", "4:1: the first column is '0'; it must be 'time [s]' or time in another unit of time"),
        ("t [s],duty [1]\n", "4:1: the first column is 't [s]'; it must be 'time [s]' or time in another unit of time"),
        ("time,duty [1]\n", "4:1: the first column is 'time'; it must be 'time [s]' or time in another unit of time"),
        ("time [A]\n", "4:1: the first column is 'time [A]'; it must be 'time [s]' or time in another unit of time"),
        ("time [s],duty [1],duty [1]\n0,1,1\n", "4:3: a second column 'duty'; each channel has one column"),
        ("time [s],time [s]\n0,0\n", "4:2: a second column 'time'; each channel has one column"),
        ("time [s],,duty [1]\n0,1,1\n", "4:2: the column has no name; expected 'name [unit]'"),
        ("time [s],duty [foo]\n0,1\n", f"4:2: column 'duty [foo]': 'foo' is not a unit; {UNITS}"),
        ("time [s],duty []\n0,1\n", f"4:2: column 'duty []': '' is not a unit; {UNITS}"),
        (
            "time [s],duty [1]\n0,\n",
            "4:2: column 'duty' has no value in any row; give one or remove the column",
        ),
        (
            "time [s],duty [1],x [1]\n0,1\n",
            "5:3: the row has 2 cells, the header 3: the cell for 'x [1]' is missing; leave it empty for 'unchanged'",
        ),
        (
            "time [s],duty [1]\n0,0,5\n",
            "5:3: the row has 3 cells, the header 2: '5' belongs to no column "
            "(is the comma a decimal comma? then separate cells with ';')",
        ),
        (
            "time [s];duty [1]\n0;1;5\n",
            "5:3: the row has 3 cells, the header 2: '5' belongs to no column",
        ),
        ("time [s],duty [1]\n0,nan\n", f"5:2: 'nan' in column 'duty [1]' {NOT_A_NUMBER}"),
        ("time [s],duty [1]\n0,#N/A\n", f"5:2: '#N/A' in column 'duty [1]' {NOT_A_NUMBER}"),
        ("time [s],duty [1]\n0,inf\n", f"5:2: 'inf' in column 'duty [1]' {NOT_A_NUMBER}"),
        ("time [s],duty [1]\n0,1e999\n", f"5:2: '1e999' in column 'duty [1]' {NOT_A_NUMBER}"),
        ("time [s],duty [1]\n0,1_0\n", f"5:2: '1_0' in column 'duty [1]' {NOT_A_NUMBER}"),
        ("time [s],duty [1]\nsoon,1\n", f"5:1: 'soon' in column 'time [s]' {NOT_A_NUMBER}"),
        ("time [s];duty [1]\n0;1.000,5\n", f"5:2: '1.000,5' in column 'duty [1]' {NOT_A_NUMBER}"),
        (
            "time [s];duty [1]\n0;0,5\n1;0.5\n",
            "6:2: '0.5' has the decimal mark '.', earlier numbers have ','; use one of them in the whole file",
        ),
        ("time [s],duty [1]\n,1\n", "5:1: the row has no time; each row starts with one"),
        ("time [s],duty [1]\n-1,1\n", "5:1: the time -1 is not in the run, which starts at 0 s"),
        ("time [s],duty [1]\n1,1\n0.5,0\n", "6:1: the time 0.5 goes back: the row above has 1"),
        (
            "time [s],duty [1]\n1,0\n1,1\n1,2\n",
            "7:1: a third row with the time 1; two rows with one time are a step",
        ),
        (
            "time [s],duty [1]\n0,0\n3,1\n",
            "6:1: the row's time 3 s is after 'stop', 2 s; let 'stop' be at least the last row's time",
        ),
        (
            'time [s],duty [1]\n0,"1\n',
            "5: the cells cannot be told apart (unexpected end of data); check the quotes",
        ),
        ("time [s],duty [1]\n0,1\n# stop: 3 s\n", "6: a '#' line below the header; '# key: value' lines come first"),
    ],
)
def test_tables_that_are_refused(tmp_path: Path, table: str, message: str) -> None:
    assert refusal(tmp_path, HEAD + table) == message


def test_files_that_are_no_table(tmp_path: Path) -> None:
    expected = "expected a header such as 'time [s],duty [1]' and rows below it"
    assert refusal(tmp_path, "") == f"an empty file; {expected}"
    assert refusal(tmp_path, "\r\n \r\n") == f"an empty file; {expected}"
    assert refusal(tmp_path, b"a\n\xb0C") == "2: byte 0xb0 is not UTF-8 text; save the file as 'CSV UTF-8'"
    assert refusal(tmp_path, "time [s]".encode("utf-16")) == "is UTF-16 text; save it as 'CSV UTF-8'"
    assert refusal(tmp_path, b"PK\n\0") == "2: is a binary file, not CSV text"
    with pytest.raises(InputError) as error:
        read(tmp_path / "none.csv")
    assert str(error.value) == f"{tmp_path / 'none.csv'}: there is no such scenario file"
    with pytest.raises(InputError) as error:
        read(tmp_path)
    assert str(error.value) == f"{tmp_path}: cannot be read: Is a directory"


def test_keys_that_are_missing(tmp_path: Path) -> None:
    assert refusal(tmp_path, "# controller: none\n# stop: 1 s\ntime [s]\n") == (
        "no '# system: ...' line; write a built-in plant such as linkage, or the path of an .fmu, .ssp or .ssd"
    )
    assert refusal(tmp_path, "# system: rig\n# stop: 1 s\ntime [s]\n") == (
        "no '# controller: ...' line; write voltage_profile, another built-in controller, the path of an .fmu, or none"
    )
    assert refusal(tmp_path, "# system: rig\n# controller: none\ntime [s],duty [1]\n0,1\n") == (
        "no '# stop: ...' line; write a time such as 25 s; it may be left out only if the rows end later than 0 s"
    )


def test_options_that_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path, HEAD + "time [s]\n")
    for option, message in {
        "stop=5": "--set: 'stop' is a time, '5' is not; write 5 s or 5 ms",
        "ext_load": "--set: 'ext_load' is not 'name = value'; write for example 'plant.ext_load = 4 N.m'",
    }.items():
        with pytest.raises(InputError) as error:
            read(path, [option])
        assert str(error.value) == message


def test_the_algorithm_and_its_macro_step(tmp_path: Path) -> None:
    keys = (
        "# system: linkage\n# controller: none\n# algorithm: extrapolated\n# macro_step: 0.2 ms\n# extrapolation: 1\n"
    )
    scenario = read(write(tmp_path, f"{keys}time [s],duty [1]\n0,1\n2,1\n"))
    assert (scenario.algorithm, scenario.macro_step, scenario.extrapolation) == ("extrapolated", 2e-4, 1)
    scenario = read(write(tmp_path, f"{keys}time [s],duty [1]\n0,1\n2,1\n"), ["algorithm=adaptive", "extrapolation=2"])
    assert (scenario.algorithm, scenario.extrapolation) == ("adaptive", 2)
    for line, message in (
        (
            "# algorithm: adaptiv",
            "'algorithm' is 'adaptiv', did you mean 'adaptive'?; write one of auto, ",
        ),
        ("# extrapolation: 3", "'extrapolation' is '3'; write the order of the polynomials, 0, 1 or 2"),
        ("# macro_step: 1 kg", "'macro_step' is a time, '1 kg' is not"),
    ):
        with pytest.raises(InputError) as caught:
            read(write(tmp_path, f"# system: linkage\n# controller: none\n{line}\ntime [s],duty [1]\n0,1\n2,1\n"))
        assert message in str(caught.value)
        assert ":3:" in str(caught.value) or "line 3" in str(caught.value)
