"""Programs that the tests run to their end."""

import os
import subprocess


def run_program(*words, status=0, variables=None, **options):
    """Run a program with an empty standard input, for 300 s at most, its outputs kept as text.

    The exit status must be `status`; None allows any. `variables` are added to the environment.
    """
    done = subprocess.run([*map(str, words)], **{
        **({} if "input" in options else {"stdin": subprocess.DEVNULL}), "capture_output": True,
        "text": True, "timeout": 300, "env": {**os.environ, **(variables or {})}, **options})
    assert status in (None, done.returncode), done.stderr or done.stdout
    return done
