"""What the command line says of itself, and to misspelt words."""

import subprocess

import pytest
from processes import run_command

COMMANDS = ("run", "serve", "mock", "check", "plan", "completion")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself_with_examples(command):
    done = run_command(command, "--help")
    assert done.returncode == 0
    assert done.stdout.startswith(f"usage: comotion {command}")
    assert f"examples:\n  comotion {command} " in done.stdout


def test_help_lists_every_command():
    done = run_command("--help")
    assert done.returncode == 0
    assert all(f"    {command} " in done.stdout or f"    {command}\n" in done.stdout for command in COMMANDS)


def test_version():
    assert run_command("--version").stdout == "comotion 0.1.0\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["rnu"],
            (
                "there is no command 'rnu'; did you mean 'run'?; "
                "allowed: run, serve, mock, watch, check, plan, report, completion"
            ),
        ),
        (["plan", "chanel"], "there is no scene 'chanel'; did you mean 'channel'?; give a scene file"),
        (["run", "drop", "--dt", "0"], "argument --dt: expected a positive number, got '0'"),
        (["run", "drop", "--duration", "nan"], "argument --duration: expected a positive number, got 'nan'"),
        (["mock", "drop"], "the following arguments are required: --run"),
        ([], "the following arguments are required: COMMAND"),
    ],
)
def test_wrong_use_is_named_and_ends_with_2(arguments, words):
    done = run_command(*arguments)
    assert done.returncode == 2
    assert words in done.stderr
    assert done.stdout == ""


@pytest.mark.parametrize("shell", ["bash", "zsh"])
def test_completion_knows_every_command(shell):
    done = run_command("completion", shell)
    assert done.returncode == 0
    assert all(command in done.stdout for command in COMMANDS)
    if shell == "bash":
        subprocess.run(["bash", "-n"], input=done.stdout, text=True, check=True)  # noqa: S607  # whichever bash there is
