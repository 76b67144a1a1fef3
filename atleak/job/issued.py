"""Issue a result as the record that other programs read: with the job it is of, and a hash by which it is known."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from atleak.diagnosis import Diagnosis
from atleak.job.doubts import record_doubts
from atleak.job.record import Job
from atleak.views.diagnosis_record import diagnosis_record
from atleak.views.message_record import message_record


def issued_record(diagnosis: Diagnosis, job: Job | None = None) -> dict[str, Any]:
    """Return the record of a diagnosis, in the form ``atleak diagnose --json`` writes.

    Parameters
    ----------
    diagnosis
        the result.
    job
        what the workshop wrote down; none where nobody did.
    """
    record = diagnosis_record(diagnosis)
    of_job = None
    if job is not None:
        of_job = {**job.identity, "doubts": [message_record(each) for each in record_doubts(job, diagnosis)]}
    return {**record, "job": of_job, "result_sha256": result_sha256(record)}


def result_sha256(record: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a result, as hexadecimal digits: the same for the same result, whosever job it is.

    It is that of the JSON in UTF-8 with keys in the order of their signs, without spaces and line ends.

    Parameters
    ----------
    record
        as `diagnosis_record` makes it.
    """
    text = json.dumps(record, ensure_ascii=False, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode("utf-8", errors="backslashreplace")).hexdigest()
