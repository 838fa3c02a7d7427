"""A whole course, as it hands in: whose each file is, what it is, and what the teacher is told where it is nothing."""

import re

import course
from grader.collect import read_roster, submissions


def test_each_file_of_a_course_is_its_students(tmp_path):
    course.write(tmp_path / "submissions")
    roster = read_roster(tmp_path / "roster.csv")
    found = {one.student: one for one in submissions(tmp_path / "submissions", roster, "moodle")}
    assert set(found) == {f"s{number}" for number in range(len(course.COURSE))}
    for number, student in enumerate(course.COURSE):
        one = found[f"s{number}"]
        assert one.gradable == student.is_notebook, student.what
        assert one.assignment in (student.assignment, None)
    said = [one.remark for one in found.values() if one.remark]
    assert len(said) == 3
    assert all(re.search("ask for (it again|the file that ends in .ipynb)", remark) for remark in said), said
