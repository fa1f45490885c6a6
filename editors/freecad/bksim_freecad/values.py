"""Values as they are typed, without the quotes and commas of TOML, and as a model file has them.

`9.8 m/s^2` is typed for `"9.8 m/s^2"`, `[0, -g]` for `[0, "-g"]`, and `{ angle = 0 }` for itself: a number, `true`,
`false` and a text in quotes are what they are, arrays and tables hold values, and all else is a text.
"""

import json
import re

NUMBER = re.compile(r"[+-]?\d[\d_]*(?:\.\d+)?(?:[eE][+-]?\d+)?")
BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
OPENING, CLOSING = "[{(", "]})"


def split(text):
    """The parts between commas, those in brackets, parentheses and quotes aside."""
    parts, depth, quote, start = [], 0, "", 0
    for idx, char in enumerate(text):
        if quote:
            quote = "" if char == quote and text[idx - 1] != "\\" else quote
        elif char in "\"'":
            quote = char
        elif char == "," and depth == 0:
            parts.append(text[start:idx])
            start = idx + 1
        else:
            depth += (char in OPENING) - (char in CLOSING)
    parts.append(text[start:])
    return [part.strip() for part in parts if part.strip()]


def key_text(key):
    """The key as TOML has it, quoted where it has to be."""
    return key if BARE_KEY.fullmatch(key) else json.dumps(key, ensure_ascii=False)


def is_quoted(text):
    """Whether a text is one text in quotes."""
    return len(text) > 1 and text[0] in "\"'" and text.find(text[0], 1) == len(text) - 1


def written(text):
    """A value of TOML from the text that was typed for it."""
    text = text.strip()
    if text.startswith("[") and text.endswith("]"):
        return "[" + ", ".join(written(part) for part in split(text[1:-1])) + "]"
    if text.startswith("{") and text.endswith("}"):
        return "{ " + ", ".join(written_pair(part) for part in split(text[1:-1])) + " }"
    if text in ("true", "false") or is_quoted(text) or NUMBER.fullmatch(text):
        return text
    return json.dumps(text, ensure_ascii=False)


def written_pair(text):
    """One `key = value` of a table."""
    key, _, value = text.partition("=")
    return f"{key.strip()} = {written(value)}"


def typed(value):
    """The text that would be typed for a value that was read from TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join(typed(part) for part in value) + "]"
    if isinstance(value, dict):
        pairs = (f"{key_text(key)} = {typed(part)}" for key, part in value.items())
        return "{ " + ", ".join(pairs) + " }"
    if isinstance(value, str):
        quoted = json.dumps(value, ensure_ascii=False)
        return value if written(f"[{value}]") == f"[{quoted}]" else quoted
    return repr(value)


def with_unit(text, unit):
    """A value in parentheses to multiply it by others; a bare number gets the unit that it is meant in."""
    text = text.strip().strip("\"'")
    return f"({text} {unit})" if NUMBER.fullmatch(text) else f"({text})"


def vector(numbers, write=repr):
    """An array of numbers."""
    return "[" + ", ".join(write(number) for number in numbers) + "]"
