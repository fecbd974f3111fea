"""Write the findings of a check as a JUnit XML file, which CI servers can show."""

from __future__ import annotations

import os
from collections.abc import Sequence
from xml.etree import ElementTree as Xml

from holdfast.base.files import write_atomically
from holdfast.base.text import one_line
from holdfast.batches.gate import FAILED, PASSED, UNDECIDED, Finding
from holdfast.report.texts import LONGEST_REASON


def write_junit(findings: Sequence[Finding], path: str | os.PathLike[str]) -> None:
    """Write one test case for each finding: a failure if the scene failed, an error if it is undecided."""
    failed, unknown = (sum(f.result == result for f in findings) for result in (FAILED, UNDECIDED))
    counts = {"tests": len(findings), "failures": failed, "errors": unknown}
    suite = Xml.Element("testsuite", {"name": "holdfast check", **{key: str(n) for key, n in counts.items()}})
    for found in findings:
        case = {"classname": "holdfast", "name": one_line(found.scene), "time": f"{found.seconds:.3f}"}
        element = Xml.SubElement(suite, "testcase", case)
        if found.result != PASSED:
            kind = "failure" if found.result == FAILED else "error"
            reason = one_line(found.reason, LONGEST_REASON)
            Xml.SubElement(element, kind, {"type": found.result, "message": reason}).text = reason
    Xml.indent(suite)
    write_atomically(path, Xml.tostring(suite, encoding="utf-8", xml_declaration=True) + b"\n")
