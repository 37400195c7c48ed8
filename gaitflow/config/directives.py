"""A user's own directives in the scripts of jobs: one option each, and none that the scripts set themselves."""

from __future__ import annotations

import re
from collections.abc import Iterable
from reprlib import repr as short
from typing import Annotated

from pydantic import AfterValidator

LINE_BREAKS = re.compile(r"[\x00-\x08\x0a-\x1f\x7f\x85\u2028\u2029]")
_SLURM = re.compile(r"--([a-z][a-z-]*)(=.*)?", re.DOTALL)
_PBS = re.compile(r"(-[A-Za-z])( [^\s-]\S*)?")  # a line of #PBS may have several options
_FORMS = {
    "slurm": 'must be one option in full, such as "--qos=long" or "--exclusive"',
    "pbs": 'must be one option of qsub, such as "-l place=excl" or "-m abe"',
}

# Options that the scripts set themselves, or that would break what they rely on, with what to use instead.
OF_SLURM = {
    "account": "use the field account",
    "array": "use the field jobs",
    "chdir": "the script goes to its folder itself",
    "comment": "it marks the jobs of a run",
    "cpus-per-task": "use the field cores",
    "dependency": "a run needs no other job",
    "error": "logs go to the run's folder",
    "hold": "a job on hold never starts",
    "input": "jobs read nothing",
    "job-name": "it names the scenario",
    "mem": "use the field memory",
    "mem-per-cpu": "use the field memory",
    "mem-per-gpu": "use the field memory",
    "no-requeue": "workers are replaced, the driver is requeued",
    "nodes": "a worker is one process",
    "ntasks": "a worker is one process",
    "ntasks-per-node": "a worker is one process",
    "open-mode": "logs are appended to",
    "output": "logs go to the run's folder",
    "parsable": "the answer of sbatch is read",
    "partition": "use the field partition",
    "quiet": "the answer of sbatch is read",
    "requeue": "workers are replaced, the driver is requeued",
    "signal": "it announces the end of the driver's walltime",
    "test-only": "use --dry-run",
    "time": "use the field walltime",
    "time-min": "use the field walltime",
    "wait": "sbatch has to return at once",
    "wrap": "the job is the worker",
}
OF_PBS = {
    "-A": "use the field account",
    "-C": "directives begin with #PBS",
    "-e": "logs go to the run's folder",
    "-h": "a job on hold never starts",
    "-I": "jobs read nothing",
    "-J": "use the field jobs",
    "-j": "logs go to the run's folder",
    "-k": "logs go to the run's folder",
    "-l mem": "use the field memory",
    "-l ncpus": "use the field cores",
    "-l nodes": "a worker is one process",
    "-l select": "use the fields cores and memory",
    "-l walltime": "use the field walltime",
    "-N": "it names the scenario",
    "-o": "logs go to the run's folder",
    "-q": "use the field partition",
    "-r": "workers are replaced, the driver is requeued",
    "-S": "the script is bash",
    "-v": "it marks the jobs of a run",
    "-W block": "qsub has to return at once",
    "-W depend": "a run needs no other job",
    "-X": "jobs read nothing",
    "-z": "the answer of qsub is read",
}


def _directive(text: str) -> str:
    slurm, pbs = _SLURM.fullmatch(text), _PBS.fullmatch(text)
    if slurm is None and pbs is None:
        raise ValueError(f'{short(text)}: {_FORMS["slurm"]}; for PBS, such as "-l place=excl"')
    if LINE_BREAKS.search(text) or "#" in text:
        raise ValueError(f"{short(text)}: must be one line without #")
    if slurm is not None:
        # sbatch takes any beginning of an option that leaves no doubt, so --ti would be --time.
        taken = next((f"--{option}" for option in OF_SLURM if option.startswith(slurm[1])), None)
        instead = OF_SLURM.get((taken or "")[2:])
    else:
        # One -l or -W may ask for several things, with commas between them.
        words = [f"{text[:2]} {word}" for word in text[3:].split(",")]
        taken = next((option for option in OF_PBS if any(re.match(rf"{option}\b", word) for word in words)), None)
        instead = OF_PBS.get(taken or "")
    if taken is not None:
        raise ValueError(f"{short(text)}: {taken} is set by gaitflow: {instead}")
    return text


Directive = Annotated[str, AfterValidator(_directive)]


def foreign_directive(scheduler: str, directives: Iterable[str]) -> str | None:
    """What is wrong with the first directive that is none of this scheduler's; None when all are."""
    form = {"slurm": _SLURM, "pbs": _PBS}[scheduler]
    found = next(((i, text) for i, text in enumerate(directives) if form.fullmatch(text) is None), None)
    return None if found is None else f"directives.{found[0]}: {short(found[1])}: {_FORMS[scheduler]}"
