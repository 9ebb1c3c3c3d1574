"""What the client returns: studies, jobs, attempts, workers. Fields have the names and meanings of `parallax ... --json`
(the table in coordinator/client/README.md). Times are Unix seconds."""

from dataclasses import dataclass, fields
from typing import Any, Dict, List, Mapping, Optional, Type, TypeVar

_T = TypeVar("_T")
_NO_SCENE = 2**32 - 1
_FINISHED = ("succeeded", "cancelled", "failed")
_COUNTS = ("pairs_wanted", "pairs_done", "frames_reused", "solves_done", "solves_reused", "layouts_reused", "scenes_rejected",
           "jobs_failed")


@dataclass(frozen=True)
class Waiting:
    """Jobs of a kind that are ready and do not run for one reason."""

    kind: str
    jobs: int
    reason: str  # "trainer", "benchmark", "tag", "memory", "gpu", "limit", "pause", "drain", "busy"...
    text: str    # For people.


@dataclass(frozen=True)
class Problem:
    """A job that failed or is tried again."""

    job_id: int
    state: str
    scene: Optional[int]
    error: str


@dataclass(frozen=True)
class Counts:
    """Counters of a variant, or their sums over a study."""

    pairs_wanted: int
    pairs_done: int
    frames_reused: int
    solves_done: int
    solves_reused: int
    layouts_reused: int
    scenes_rejected: int
    jobs_failed: int


@dataclass(frozen=True)
class Variant(Counts):
    name: str
    jobs: Dict[str, Dict[str, int]]  # Numbers by kind and state: {"render": {"ready": 3}}.
    problems: List[Problem]          # The newest first, at most 10.


@dataclass(frozen=True)
class Comment:
    unix_s: float
    actor: str  # Who wrote it.
    text: str


@dataclass(frozen=True, repr=False)
class Study(Counts):
    study_id: int
    name: str
    state: str  # "running", "paused", "succeeded", "cancelled" or "failed".
    user: str
    running: int
    max_running: int
    priority: int
    at_limit: str
    held_jobs: int
    waiting: List[Waiting]
    submitted_unix_s: float
    finished_unix_s: float  # 0 while it runs.
    variants: List[Variant]
    comments: List[Comment]  # The newest first, at most 20; only of one study's status.

    def __repr__(self) -> str:
        return f"Study({self.study_id}, {self.name!r}, {self.state}, {self.pairs_done}/{self.pairs_wanted} pairs)"

    @property
    def finished(self) -> bool:
        return self.state in _FINISHED

    def jobs(self, *states: str) -> Dict[str, int]:
        """Numbers of jobs by kind, over all variants: in these states, or in any."""
        numbers: Dict[str, int] = {}
        for variant in self.variants:
            for kind, by_state in variant.jobs.items():
                jobs = sum(number for state, number in by_state.items() if not states or state in states)
                if jobs:
                    numbers[kind] = numbers.get(kind, 0) + jobs
        return numbers


@dataclass(frozen=True)
class Job:
    job_id: int
    kind: str
    state: str  # "blocked", "ready", "leased", "retry_wait", "succeeded", "rejected", "failed", "quarantined", "cancelled".
    variant: str
    scene: Optional[int]
    rigs: List[int]
    attempts: int
    worker: str
    fraction: float
    stage: str
    error: str
    waits_reason: str
    waits_text: str
    label: str
    figures: Dict[str, float]  # Of a running training: "loss", "step", "eta_s"...
    log_tail: str


@dataclass(frozen=True)
class Attempt:
    fence: str
    ending: str  # "running", "succeeded", "rejected", "failed", "lost", "returned" or "cancelled".
    worker: str
    unix_s: float  # When it ended; 0 while it runs.
    error: str
    log_tail: str


@dataclass(frozen=True)
class Worker:
    name: str
    state: str
    kinds: List[str]
    slots: int
    running: int
    last_heard_s: float
    version: str
    drained_by: str


@dataclass(frozen=True)
class Forgotten:
    """What a forgotten study had."""

    jobs: int
    pairs: int
    results: int


@dataclass(frozen=True)
class Submitted:
    study_id: int
    name: str
    existed: bool  # This very study was there already; nothing was submitted.
    state: str
    variants: int
    pairs_wanted: int
    content_files: int
    content_bytes: int
    unservable: List[Waiting]  # Jobs that no connected worker could run; their `jobs` is 0.


@dataclass(frozen=True)
class Fetched:
    study_id: int
    name: str
    state: str
    out: str
    frames: int
    frames_added: int
    frames_present: int
    frames_replaced: int
    frames_damaged: int
    files_linked: int
    files_copied: int
    files_streamed: int
    trainings: int
    evaluations: int


def of_json(kind: Type[_T], json: Mapping[str, Any]) -> _T:
    """One of the classes above from the program's JSON. Later releases may have more fields."""
    return kind(**{field.name: json[field.name] for field in fields(kind)})  # type: ignore[arg-type]


def of_message(kind: Type[_T], message: Any, **others: Any) -> _T:
    """One of the classes above from a message with fields of the same names, beside `others`."""
    plain = {field.name: getattr(message, field.name) for field in fields(kind) if field.name not in others}  # type: ignore[arg-type]
    return kind(**plain, **others)


def scene_of(message: Any) -> Optional[int]:
    return int(message.scene) if message.job_id and message.scene != _NO_SCENE else None


def _variant(message: Any) -> Variant:
    jobs: Dict[str, Dict[str, int]] = {}
    for count in message.jobs:
        jobs.setdefault(count.kind, {})[count.state.lower()] = count.jobs
    problems = [of_message(Problem, one, state=one.state.lower(), scene=scene_of(one)) for one in message.problems]
    failed = sum(by_state.get(state, 0) for by_state in jobs.values() for state in ("failed", "quarantined"))
    return of_message(Variant, message, jobs=jobs, problems=problems, jobs_failed=failed,
                      solves_done=jobs.get("solve", {}).get("succeeded", 0))


def study_of(message: Any) -> Study:
    """A StudyStatus. A state that this release does not know is its number."""
    variants = [_variant(one) for one in message.variants]
    states = message.DESCRIPTOR.fields_by_name["state"].enum_type.values_by_number
    name = states[message.state].name if message.state in states else str(message.state)
    return of_message(
        Study, message, variants=variants, waiting=[of_message(Waiting, one) for one in message.waiting],
        comments=[of_message(Comment, one) for one in message.comments],
        state=name.replace("STUDY_STATE_", "").lower(), running=sum(sum_of.get("leased", 0) for variant in variants
                                                                    for sum_of in variant.jobs.values()),
        **{count: sum(getattr(variant, count) for variant in variants) for count in _COUNTS})
