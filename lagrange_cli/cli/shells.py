"""Completion in bash, zsh and fish: what a shell asks, and the script by which it asks.

click's own scripts would offer every file.
"""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import Any, ClassVar

import click
from click.shell_completion import (
    BashComplete,
    CompletionItem,
    FishComplete,
    ShellComplete,
    ZshComplete,
    add_completion_class,
    get_completion_class,
    shell_complete,
)

VARIABLE = "_LAGRANGE_COMPLETE"
SHELLS = ("bash", "zsh", "fish")

BASH = r"""%(complete_func)s() {
    local IFS=$'\n' current=${COMP_WORDS[COMP_CWORD]} kind value match files=
    COMPREPLY=()
    [[ $current == '=' ]] && current=
    while IFS=, read -r kind value; do
        if [[ $kind == plain ]]; then
            COMPREPLY+=("$value")
            [[ $value == *[=[] ]] && compopt -o nospace
        elif [[ $kind == ending ]]; then
            files=1
            while IFS= read -r match; do
                COMPREPLY+=("$match")
            done < <(compgen -f -X "!*.$value" -- "$current")
        elif [[ $kind == dir ]]; then
            files=1
            while IFS= read -r match; do
                COMPREPLY+=("$match")
            done < <(compgen -d -- "$current")
        elif [[ $kind == file ]]; then
            files=1
        fi
    done < <(
        COMP_WORDS="${COMP_WORDS[*]}" COMP_CWORD=$COMP_CWORD %(complete_var)s=bash_complete "$1" 2>/dev/null
    )
    if [[ $files ]]; then
        compopt -o filenames
        [[ ${#COMPREPLY[@]} == 0 ]] && compopt -o default
    fi
    return 0
}

complete -o nosort -F %(complete_func)s %(prog_name)s 2>/dev/null ||
    complete -F %(complete_func)s %(prog_name)s
"""


class Bash(BashComplete):
    """Bash, which takes ``--method=taylor`` and ``m=1`` for three words each."""

    name: ClassVar[str] = "bash"
    source_template: ClassVar[str] = BASH

    def source(self) -> str:
        return ShellComplete.source(self)  # click's also runs bash, to look at its version

    def get_completion_args(self) -> tuple[list[str], str]:
        before, last = super().get_completion_args()
        words: list[str] = []
        for word in [*before, last]:
            if words and (word == "=" or words[-1].endswith("=")):
                words[-1] += word
            else:
                words.append(word)
        return words[:-1], words[-1]

    def format_completion(self, item: CompletionItem[Any]) -> str:
        if item.type == "file" and item.endings:
            return "\n".join([*(f"ending,{ending}" for ending in item.endings), "dir,"])
        return super().format_completion(item)


ZSH = (
    ZshComplete.source_template.replace("_path_files -f", '_files -g "$key"')
    .replace("%(prog_name)s)}", "%(prog_name)s 2>/dev/null)}")
    .replace(
        "compadd -U -V unsorted -a completions",
        """local -a open
        open=(${(M)completions:#*[=\\[]})
        completions=(${completions:#*[=\\[]})
        compadd -U -S '' -V unsorted -a open
        compadd -U -V unsorted -a completions""",
    )
)


class Zsh(ZshComplete):
    """Zsh, which is given the pattern of the files."""

    name: ClassVar[str] = "zsh"
    source_template: ClassVar[str] = ZSH

    def format_completion(self, item: CompletionItem[Any]) -> str:
        if item.type == "file":
            pattern = f"*.({'|'.join(item.endings)})" if item.endings else "*"
            item = CompletionItem(pattern, type="file")
        return super().format_completion(item)


FISH = r"""function %(complete_func)s
    set -l token (commandline -ct)
    set -l option (string match -r -- '^--[^=]+=' "$token"; or echo)
    set -l files
    set -l endings
    for line in (env %(complete_var)s=fish_complete "COMP_WORDS="(commandline -cp) "COMP_CWORD=$token" \
            %(prog_name)s 2>/dev/null)
        set -l item (string split -m 1 -- , $line)
        switch $item[1]
            case plain
                echo "$option$item[2]"
            case ending
                set files yes
                set -a endings $item[2]
            case file dir
                set files yes
        end
    end
    test -n "$files"; or return 0
    set -l all (__fish_complete_path (string replace -- "$option" '' "$token" | string unescape))
    set -l fitting $all
    if set -q endings[1]
        set fitting (string match -r -- '^[^\t]*(?:/|[.](?:'(string join '|' $endings)'))(?:\t.*)?$' $all)
        set -q fitting[1]; or set fitting $all
    end
    for file in $fitting
        echo "$option$file"
    end
end

complete --no-files --command %(prog_name)s --arguments '(%(complete_func)s)'
"""


class Fish(FishComplete):
    """Fish, which is given the endings of the files; ``--method=taylor`` is one word there."""

    name: ClassVar[str] = "fish"
    source_template: ClassVar[str] = FISH

    def format_completion(self, item: CompletionItem[Any]) -> str:
        if item.type == "file" and item.endings:
            return "\n".join(f"ending,{ending}" for ending in item.endings)
        described = f"\t{' '.join(item.help.split())}" if item.help else ""
        return f"{item.type},{item.value}{described}"


def answer(cli: click.Command) -> int:
    """Say what the shell has asked for in its variables, and nothing else."""
    with open(os.devnull, "w", encoding="utf-8") as nowhere:
        stderr, sys.stderr = sys.stderr, nowhere
        try:
            with suppress(Exception):
                register()
                shell_complete(cli, {}, "lagrange", VARIABLE, os.environ[VARIABLE])
        finally:
            sys.stderr = stderr
    return 0


def script(cli: click.Command, shell: str) -> str:
    """The script that has the shell ask."""
    register()
    kind = get_completion_class(shell)
    assert kind is not None
    return kind(cli, {}, "lagrange", VARIABLE).source()


def register() -> None:
    """Have click use these shells."""
    add_completion_class(Bash)
    add_completion_class(Zsh)
    add_completion_class(Fish)
