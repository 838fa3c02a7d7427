"""What a teacher gets and enters: marks by hand, totals, pages, and what is to be looked at."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from grader import look, masters, questions, report, run, tables
from grader.collect import Submission
from grader.run import Result
from submissions import handed_in

NAME = "dual_quaternions"

# ---- marks by hand ---------------------------------------------------------------------------------------

ANSWER = {"cell": "argument", "points": 5.0, "mark": None, "remark": "", "answer": "<script>alert(1)</script>"}
ANSWER["untouched"] = False


def waiting() -> list[Result]:
    return [Result(Submission("ada", Path("goldberg.ipynb"), "goldberg"), [dict(ANSWER)])]


def by_hand(results, file):
    return report.with_marks_by_hand(results, file)[0][0].marks[0]


def test_marks_by_hand_are_asked_for_once_and_taken_over(tmp_path):
    file = tmp_path / "by_hand.csv"
    assert by_hand(waiting(), file)["mark"] is None
    asked = file.read_text(encoding="utf-8-sig")
    assert "ada,goldberg,argument,5,,," in asked
    filled = asked.replace(",", ";").replace(";5;;;", ';5;4,5;"well; argued,\n- but long";')
    file.write_text(filled, encoding="utf-8-sig")
    mark = by_hand(waiting(), file)
    assert (mark["mark"], mark["remark"], mark["marked"]) == (4.5, "well; argued,\n- but long", "hand")
    assert len(tables.read(file)) == 1


def test_no_remark_is_a_formula(tmp_path):
    mark = {"cell": "norm", "points": 2.0, "mark": 0.0, "marked": "auto", "remark": "=1+1"}
    report.write_marks([Result(Submission("@ada", Path("x.ipynb"), "bennett"), [mark])], tmp_path / "marks.csv")
    assert (tmp_path / "marks.csv").read_text().splitlines()[1] == "'@ada,bennett,norm,2,0,auto,'=1+1"


@pytest.mark.parametrize("entered", ["6", "-1", "good"])
def test_a_mark_by_hand_that_cannot_be_is_refused(tmp_path, entered):
    file = tmp_path / "by_hand.csv"
    file.write_text(f"student,assignment,cell,points,mark,comment\nada,goldberg,argument,5,{entered},\n")
    with pytest.raises(tables.EntryError, match="from 0 to 5 for ada, goldberg, argument"):
        report.with_marks_by_hand(waiting(), file)


def test_a_feedback_page_shows_answers_as_text(tmp_path):
    report.write_feedback(report.with_marks_by_hand(waiting(), tmp_path / "by_hand.csv")[0], tmp_path)
    page = (tmp_path / "ada.html").read_text(encoding="utf-8")
    assert "&lt;script&gt;" in page
    assert "<script>" not in page


def automatic(mark: float = 0.0, answer: str = "def norm(q):\n    return 5, 0", student: str = "ada") -> Result:
    found = {"cell": "norm-of-all", "points": 2.0, "mark": mark, "remark": "b is 0", "answer": answer}
    return Result(Submission(student, Path(f"{NAME}.ipynb"), NAME), [{**found, "untouched": False}])


def enter(file: Path, *lines: str) -> None:
    file.write_text("student,assignment,cell,points,mark,comment\n" + "\n".join(lines), encoding="cp1252")


def test_a_row_overrides_an_automatic_mark(tmp_path):
    enter(tmp_path / "by_hand.csv", f"Ada,{NAME},norm-of-all,,1.5,für die Idee")
    mark = by_hand([automatic()], tmp_path / "by_hand.csv")
    assert (mark["mark"], mark["remark"], mark["marked"]) == (1.5, "für die Idee", "hand")
    assert by_hand([automatic()], tmp_path / "by_hand.csv") == mark


@pytest.mark.parametrize(("result", "left"), [(automatic(), 0.0), (waiting()[0], None)])
def test_a_changed_answer_asks_again(tmp_path, result, left):
    file, one = tmp_path / "by_hand.csv", result.submission
    enter(file, f"{one.student},{one.assignment},{result.marks[0]['cell']},,1,good")
    assert by_hand([result], file)["mark"] == 1
    changed = replace(result, marks=[{**result.marks[0], "answer": "something else"}])
    results, said = report.with_marks_by_hand([changed], file)
    assert (results[0].marks[0]["mark"], len(said)) == (left, 1)
    assert "has changed since it was marked 1" in said[0]
    (row,) = tables.read(file)
    assert (row["mark"], "marked 1: mark it again good" in row["comment"]) == ("", True)
    assert report.with_marks_by_hand([changed], file)[1] == []


@pytest.mark.parametrize("row", [f"adda,{NAME},norm-of-all,,1,", f"ada,{NAME},norm,,1,"])
def test_a_row_that_matches_nothing_is_reported_and_kept(tmp_path, row):
    enter(tmp_path / "by_hand.csv", row)
    results, said = report.with_marks_by_hand([automatic()], tmp_path / "by_hand.csv")
    assert results[0].marks[0]["mark"] == 0
    assert "is not among what was graded" in said[0]
    assert len(tables.read(tmp_path / "by_hand.csv")) == 1


def test_a_row_that_stands_there_twice_is_reported(tmp_path):
    enter(tmp_path / "by_hand.csv", f"ada,{NAME},norm-of-all,,1,", f"ada,{NAME},norm-of-all,,2,")
    results, said = report.with_marks_by_hand([automatic()], tmp_path / "by_hand.csv")
    assert (results[0].marks[0]["mark"], len(said)) == (2, 1)


def test_marks_by_hand_of_what_could_not_be_run_are_kept(tmp_path):
    file = tmp_path / "by_hand.csv"
    enter(file, f"ada,{NAME},norm-of-all,,1,")
    failed = replace(automatic(), marks=[], failed=True, remark="could not be run")
    assert report.with_marks_by_hand([failed], file)[1] == []
    assert by_hand([automatic()], file)["mark"] == 1


# ---- tables ----------------------------------------------------------------------------------------------


def test_totals_have_the_maximum_what_waits_and_percentages(tmp_path):
    failed = replace(automatic(student="emmy"), marks=[], failed=True, remark="could not be run")
    report.write_totals([automatic(1.5), *waiting(), failed], tmp_path / "totals.csv")
    rows = {row["student"]: row for row in tables.read(tmp_path / "totals.csv")}
    assert [rows["(max)"][name] for name in (NAME, "goldberg", "total")] == ["20", "20", "40"]
    names = (NAME, "goldberg", "total", "max", "waiting", "percent")
    assert [rows["ada"][name] for name in names] == ["1.5", "0", "1.5", "40", "5", "3.8"]
    assert (rows["emmy"][NAME], rows["emmy"]["waiting"]) == ("", "20")


def test_tables_are_written_for_spreadsheets_here_and_there(tmp_path):
    report.write_marks(
        report.with_marks_by_hand([automatic(1.5, student="Zoë")], tmp_path / "x")[0], tmp_path / "m", ";"
    )
    assert (tmp_path / "m").read_bytes().startswith(b"\xef\xbb\xbf")
    assert "Zoë;dual_quaternions;norm-of-all;2;1,5;auto;b is 0" in (tmp_path / "m").read_text(encoding="utf-8-sig")


def test_a_file_of_marks_by_hand_keeps_its_separator(tmp_path):
    file = tmp_path / "by_hand.csv"
    file.write_text(f"student;assignment;cell;mark;comment\nada;{NAME};norm-of-all;1,5;gut\n", encoding="utf-16")
    assert by_hand([automatic()], file)["mark"] == 1.5
    assert file.read_text(encoding="utf-8-sig").splitlines()[1].startswith(f"ada;{NAME};norm-of-all;2;1,5;gut;")


# ---- pages -----------------------------------------------------------------------------------------------


def test_the_hardest_question_is_first_and_each_has_a_page_with_all_answers(tmp_path):
    easy = {"cell": "moved-point", "points": 2.0, "mark": 2.0, "remark": "", "answer": "<b>", "untouched": False}
    both = [replace(one, marks=[easy, *one.marks]) for one in (automatic(), automatic(student="emmy", mark=1.0))]
    both, _ = report.with_marks_by_hand(both, tmp_path / "by_hand.csv")
    questions.write_pages(both, [], ["a row matches nothing"], tmp_path, "in a box")
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert page.index("norm of all") < page.index("moved point")
    assert [
        words for words in ("In a box.", "a row matches nothing", "25 %", "1 part 1 none") if words not in page
    ] == []
    answers = (tmp_path / "questions" / f"{NAME}-moved-point.html").read_text(encoding="utf-8")
    assert answers.count("&lt;b&gt;") == 2
    assert re.findall("<h2>(.*?):", answers) == ["ada", "emmy"]


def test_progress_tells_the_time_that_is_left(monkeypatch):
    lines, clock = [], iter([0, 60, 70])
    monkeypatch.setattr(run.time, "monotonic", lambda: next(clock))
    run.Progress(4, lines.append).tell(automatic())
    assert lines == ["[1/4, 3 min left] ada  dual_quaternions: 0 of 2"]


def test_one_question_is_marked_anew_and_the_others_are_left(tmp_path, monkeypatch):
    path = handed_in(NAME, tmp_path, None)
    one = Submission("ada", path, NAME)
    mark = {"points": 2.0, "mark": 0.0, "remark": "", "answer": "", "untouched": False}
    old = [{**mark, "cell": "norm-of-all"}, {**mark, "cell": "moved-point"}]
    run.keep(Result(one, old), run.Limits(), tmp_path)
    monkeypatch.setattr(run, "marked", lambda *given: Result(one, [{**new, "mark": 2.0} for new in old]))
    found = run.graded(one, run.Limits(cell=7), tmp_path, "norm-of-all")
    assert [new["mark"] for new in found.marks] == [2, 0]


# ---- look at this ----------------------------------------------------------------------------------------


def seen(folder: Path, changes: dict | None, student: str = "ada", mark: float = 0.0) -> list[str]:
    path = handed_in(NAME, folder, changes)
    untouched = changes is None
    norm = {"cell": "norm-of-all", "points": 2.0, "mark": mark, "remark": "", "answer": "", "untouched": untouched}
    return [one.what for one in look.findings([Result(Submission(student, path, NAME), [norm])])]


def test_honest_work_is_not_listed(tmp_path):
    assert seen(tmp_path, {}, mark=2.0) == []
    assert seen(tmp_path, None) == []


def test_another_id_is_listed(tmp_path):
    assert seen(tmp_path, {"student": 'student = "emmy"'}) == ["the id that is written is 'emmy'"]
    assert seen(tmp_path, {"student": 'student = " ADA "'}) == []


def test_a_full_mark_for_nothing_is_listed(tmp_path):
    assert seen(tmp_path, None, mark=2.0) == ["full mark, but the answer is untouched"]


def written(texts: list[str], student: str, path: Path) -> Result:
    mark = {"points": 1.0, "mark": 1.0, "remark": "", "untouched": False}
    return Result(Submission(student, path, NAME), [{**mark, "cell": t[:9], "answer": t} for t in texts])


def test_equal_answers_are_listed_for_each_pair(tmp_path):
    path = handed_in(NAME, tmp_path, {})
    products = ", ".join(f"q[{n}] * r[{n}]" for n in range(8))
    texts = [f"def f{n}(q, r):\n    '''Mine.'''\n    return [{n}, {products}]  # so" for n in range(3)]
    copied = [text.replace("Mine", "Yours").replace("# so", "# my own") for text in texts]
    (found,) = look.alike([written(texts, "ada", path), written(copied, "emmy", path)])
    assert found.what == "3 long answers are equal to those of emmy"
    assert look.alike([written(texts, "ada", path), written(copied[:2], "emmy", path)]) == []


def test_the_solved_notebooks_answers_are_listed(tmp_path):
    path = handed_in(NAME, tmp_path, {})
    (found,) = look.alike([written([*masters.answers(masters.read(path)).values()], "ada", path)])
    assert "those of the solved notebook" in found.what
