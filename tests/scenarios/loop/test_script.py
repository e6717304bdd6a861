"""Tests of timed instructions: a file is read, or one line says what is wrong with it."""

import pytest

from scenarios.files.errors import BadInputError
from scenarios.loop.person.script import Timed, read_script

SAID = (Timed(time_s=2.5, text="move left arm higher"), Timed(time_s=10, text="etwas höher\tbitte"))


@pytest.mark.parametrize(
    "content",
    [
        "2.5\tmove left arm higher\n\n10\tetwas höher\tbitte\n",
        '{"time_s": 2.5, "text": "move left arm higher"}\n10.0\tetwas höher\tbitte',
        '2.5\tmove left arm higher\r\n{"text": "etwas höher\\tbitte", "time_s": 10}\r\n',
    ],
)
def test_a_line_is_a_time_and_words(tmp_path, content):
    path = tmp_path / "said.tsv"
    path.write_bytes(content.encode())
    assert read_script(path) == SAID


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("2.5 move left", "there is no tab"),
        ("soon\tstop", "'soon' is no time in s"),
        ("-1\tstop", "-1.0 is no time in s"),
        ("nan\tstop", "nan is no time in s"),
        ("inf\tstop", "inf is no time in s"),
        ("3\t ", "there is no text"),
        ('{"time_s": 3}', "it has time_s"),
        (
            '{"time_s": 3, "text": "stop"',
            "it is not JSON: Expecting ',' delimiter: line 1 column 29 (char 28)",
        ),
        ('{"time_s": "3", "text": "stop"}', "'3' is no time in s"),
        ('{"time_s": true, "text": "stop"}', "True is no time in s"),
        ('{"time_s": 3, "text": 4}', "there is no text"),
        ('{"time_s": 3, "text": "stop", "who": 1}', "it has text, time_s, who"),
    ],
)
def test_another_line_is_refused_with_its_number_and_what_is_allowed(tmp_path, line, why):
    path = tmp_path / "said.tsv"
    path.write_text(f"1\tpause\n\n{line}\n4\tresume\n")
    with pytest.raises(BadInputError) as refusal:
        read_script(path)
    said = str(refusal.value)
    assert f"{path}, line 3: {why}; allowed: SECONDS<tab>TEXT" in said
    assert "\n" not in said


def test_a_file_that_is_no_text_or_not_there_is_bad_input(tmp_path):
    (tmp_path / "said.tsv").write_bytes(b"\xff\xfe\x00")
    for name, why in (("said.tsv", "UTF-8"), ("none.tsv", "No such file")):
        with pytest.raises(BadInputError, match=f"{name}: .*{why}"):
            read_script(tmp_path / name)
