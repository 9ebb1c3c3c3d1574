#!/usr/bin/env python3
"""Asks the completion of a shell, or the manual page, for every command and option that --help names.

Usage: completion_test.py BIN bash|zsh|fish|man. Exit code 77: what it needs is not installed."""
import os
import pathlib
import pty
import re
import select
import shutil
import subprocess
import sys
import tempfile
import time

PROGRAMS = ("parallax", "coordinator", "worker")
COMMANDS = re.compile(r"^(?:On this machine|With a coordinator|Commands|Subcommands):\n((?:  .*\n)+)", re.MULTILINE)


def output(*command, **more):
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, **more)
    assert done.returncode == 0, f"{command}: exit code {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def tables(program, path=()):
    """Yields (path, commands, options) of the program and all commands below, as --help names them."""
    text = output(program, *path, "--help")
    commands = [line.split()[0] for part in COMMANDS.findall(text) for line in part.splitlines() if line[2] != " "]
    options = set()
    for line in text[: text.find("Examples:")].splitlines():
        if re.match(r" {2,6}-", line):
            options |= set(re.findall(r"(?:^|[ ,])(--?[a-z][-\w]*)", re.split(" {2,}", line.strip())[0]))
    yield path, commands, options
    for command in commands:
        yield from tables(program, (*path, command))


def ask_bash(script, words):
    quoted = " ".join(f"'{word}'" for word in words)
    return output("bash", "--norc", "-c", f"source '{script}'; COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; "
                  f"_{words[0]}; printf '%s\\n' \"${{COMPREPLY[@]}}\"").split()


def ask_zsh(script, words):
    """What _arguments is given; TypesInZsh tries that it understands it."""
    quoted = " ".join(f"'{word}'" for word in words)
    specs = output("zsh", "-f", "-c", f"compdef() {{ }}; _arguments() {{ print -rl -- \"$@\"; }}; source '{script}'; "
                   f"words=({quoted}); CURRENT={len(words)}; _{words[0]}").splitlines()
    if words[-2].startswith("-"):
        return [word for spec in specs if re.match(rf"\*?{words[-2]}=?\[", spec)
                for word in spec.rpartition(":(")[2].rstrip(")").split()]
    below = [re.findall(r"(?:^| )([\w-]+)\\:", spec.partition("((")[2]) for spec in specs if "((" in spec]
    return [re.match(r"\*?(--?[\w-]+)", spec)[1] for spec in specs if re.match(r"\*?-", spec)] + sum(below, [])


def ask_fish(script, words):
    lines = output("fish", "--no-config", "-c", f"source '{script}'; complete -C '{' '.join(words)}'").splitlines()
    return [line.split("\t")[0] for line in lines]


def type_in_zsh(script, text):
    """Types into an interactive zsh, and returns the arguments that the line then has."""
    child, fd = pty.fork()
    if child == 0:
        os.environ.update(TERM="dumb", PS1="> ")
        os.execvp("zsh", ["zsh", "-f", "-i"])
    seen = ""

    def until(wanted):
        nonlocal seen
        end = time.monotonic() + 30
        while wanted not in seen:
            assert time.monotonic() < end, f"zsh does not say {wanted!r}: {seen!r}"
            if select.select([fd], [], [], 0.2)[0]:
                seen += os.read(fd, 65536).decode(errors="replace")
        seen = seen.partition(wanted)[2]

    try:
        os.write(fd, f"autoload -Uz compinit; compinit -D -u; source '{script}'; parallax() {{ print -r R\"[$*]\" }}; "
                     "print REA''DY\n".encode())
        until("READY\r\n")
        os.write(fd, (text + "\n").encode())
        until("R[")
        end = time.monotonic() + 30
        while "]" not in seen and time.monotonic() < end:
            seen += os.read(fd, 65536).decode(errors="replace")
        return seen.partition("]")[0]
    finally:
        os.close(fd)
        os.waitpid(child, 0)


def check_shell(shell, ask, bin_dir, scripts):
    asked = 0
    for program in PROGRAMS:
        script = scripts / program
        script.write_text(output(bin_dir / program, "completion", shell))
        for path, commands, options in tables(bin_dir / program):
            dash = ask(script, [program, *path, "--"])
            missing = {option for option in options if option.startswith("--")} - set(dash)
            assert not missing, f"{shell}: `{program} {' '.join(path)} --` does not offer {sorted(missing)}"
            missing = set(commands) - set(ask(script, [program, *path, ""]))
            assert not missing, f"{shell}: `{program} {' '.join(path)} ` does not offer {sorted(missing)}"
            asked += len(options) + len(commands)
    assert asked > 200, asked
    offered = ask(scripts / "coordinator", ["coordinator", "serve", "--store-access", ""])
    assert sorted(offered) == ["auto", "direct", "stream"], f"{shell}: values of --store-access: {offered}"
    return asked


def check_man(bin_dir, scripts):
    asked = 0
    for program in PROGRAMS:
        page = scripts / f"{program}.1"
        page.write_text(output(bin_dir / program, "completion", "man"))
        sections = {}
        for part in re.split(r"^\.S[SH] ", page.read_text().replace("\\-", "-"), flags=re.MULTILINE):
            sections[part.partition("\n")[0]] = part
        for path, _, options in tables(bin_dir / program):
            name = " ".join((program, *path))
            part = [text for title, text in sections.items()
                    if (title == "OPTIONS" if not path else re.match(rf"{name}( [^a-z]|$)", title))]
            assert len(part) == 1, f"{program}.1: {len(part)} sections of {name}"
            missing = options - set(re.findall(r"--?[\w][-\w]*", part[0]))
            assert not missing, f"{program}.1: {name} lacks {sorted(missing)}"
            asked += len(options)
        if shutil.which("mandoc"):
            lint = subprocess.run(["mandoc", "-T", "lint", "-W", "warning", page], capture_output=True, text=True, check=False)
            faults = [line for line in lint.stdout.splitlines() if "missing date" not in line]
            assert not faults, "\n".join(faults)
        shown = subprocess.run(["man", "--warnings", "-l", "-Tutf8", "-Z", page], capture_output=True, text=True, check=False)
        assert shown.returncode == 0 and not shown.stderr, shown.stderr
    return asked


def main():
    bin_dir, shell = pathlib.Path(sys.argv[1]), sys.argv[2]
    if not shutil.which(shell):
        print(f"completion: {shell} is not installed, skipped (apt-get install {shell}{'-db mandoc' * (shell == 'man')})")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        scripts = pathlib.Path(folder)
        if shell == "man":
            asked = check_man(bin_dir, scripts)
        else:
            asked = check_shell(shell, {"bash": ask_bash, "zsh": ask_zsh, "fish": ask_fish}[shell], bin_dir, scripts)
        if shell == "bash":
            assert ask_bash(scripts / "parallax", ["parallax", "completion", "f"]) == ["fish"]
            assert ask_bash(scripts / "coordinator", ["coordinator", "serve", "--store-access", "=", "d"]) == ["direct"]
        if shell == "zsh":
            typed = type_in_zsh(scripts / "parallax", "parallax expo\tout --layo\tkitti")
            assert typed == "export out --layout=kitti", typed
            typed = type_in_zsh(scripts / "parallax", "parallax scene sho\tx --textp\t")
            assert typed.rstrip() == "scene show x --textproto", typed
    print(f"completion: {shell} knows {asked} commands and options")
    return 0


if __name__ == "__main__":
    sys.exit(main())
