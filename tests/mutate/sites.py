# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""Where a header can be changed, and into what.

This relies on headers formatted by clang-format: a binary operator has a blank before and after it; the angle
brackets of templates, references, pointers and signs do not. So a few rules on tokens are enough, and no parser is
needed. A change where the rules are wrong does not compile and is counted as stillborn.
"""
import bisect
import hashlib
import re
from dataclasses import dataclass, replace

TOKEN = re.compile(
    r"""(?P<comment>//[^\n]*|/\*.*?\*/)
      | (?P<directive>(?:(?<=\n)|\A)[ \t]*\#(?:\\\n|[^\n])*)
      | (?P<text>[A-Za-z0-9]*R"(?P<mark>[^(\s]*)\(.*?\)(?P=mark)"|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')
      | (?P<number>(?:0[xX][0-9A-Fa-f']+|0[bB][01']+|\d[\d']*(?:\.\d*)?(?:[eE][+-]?\d+)?)[A-Za-z_]*)
      | (?P<word>[A-Za-z_]\w*)
      | (?P<op><<=|>>=|<=>|\.\.\.|->|::|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|\S)""",
    re.X | re.S,
)

OPERATORS = {
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==",
    "+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=",
    "&&": "||", "||": "&&",
    "&": "|", "|": "&", "^": "|", "<<": ">>", ">>": "<<",
    "&=": "|=", "|=": "&=", "^=": "|=", "<<=": ">>=", ">>=": "<<=",
}  # fmt: skip
ASSIGNMENTS = {"=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>="}
# Words that begin a statement other than an expression.
KEYWORDS = set(
    """alignas auto bool case char class concept const consteval constexpr constinit default delete do double else
    enum explicit extern float for friend if inline int long mutable namespace noexcept operator private protected
    public requires short signed static static_assert struct switch template typedef typename union unsigned using
    virtual void volatile while""".split()
)
CLOSING = {"(": ")", "[": "]", "{": "}"}


@dataclass(frozen=True)
class Token:
    kind: str
    text: str
    start: int
    end: int


@dataclass(frozen=True)
class Site:
    """One change of one file."""

    file: str
    line: int
    column: int
    start: int
    end: int
    new: str
    what: str  # "`<` -> `<=`"
    line_text: str

    @property
    def where(self):
        return f"{self.file}:{self.line}:{self.column}"

    @property
    def key(self):
        """How survivors.txt identifies the change: without the line number, which may change."""
        return (self.file, self.what, self.line_text)


def one_line(code, most=60):
    code = " ".join(code.split())
    return code if len(code) <= most else code[: most - 3] + "..."


class Header:
    """The tokens of a header and the changes that they allow."""

    def __init__(self, file, source):
        self.file = file
        self.source = source
        self.tokens = [
            Token(m.lastgroup if m.lastgroup != "mark" else "text", m[0], m.start(), m.end())
            for m in TOKEN.finditer(source)
            if m.lastgroup not in ("comment", "directive")
        ]
        self.line_starts = [0] + [m.end() for m in re.finditer("\n", source)]
        self.partner, self.inside = self._brackets()
        self.skipped = self._skipped()

    def text(self, i):
        return self.tokens[i].text if 0 <= i < len(self.tokens) else ""

    def _has_blanks(self, i):
        t = self.tokens[i]
        return self.source[t.start - 1].isspace() and self.source[t.end].isspace()

    def _brackets(self):
        """The partner of each bracket, and for each token the innermost bracket around it."""
        partner, inside, open_ones = {}, {}, []
        for i, t in enumerate(self.tokens):
            inside[i] = open_ones[-1] if open_ones else None
            if t.text in CLOSING:
                open_ones.append(i)
            elif t.text in CLOSING.values() and open_ones:
                partner[open_ones[-1]] = i
                partner[i] = open_ones.pop()
                inside[i] = open_ones[-1] if open_ones else None
        return partner, inside

    def _skipped(self):
        """Tokens in angle brackets, in attributes, in an operator's name, and in the assertions that are tests
        themselves: those in a namespace, at the beginning of a line."""
        skipped = set()
        depth = 0
        for i, t in enumerate(self.tokens):
            if self.text(i - 1) == "operator":
                skipped.add(i)
                continue
            is_angle = t.text in ("<", ">", ">>") and (
                not self._has_blanks(i) or self.text(i - 1) == "template"
            )
            if is_angle and t.text == "<":
                depth += 1
            if depth > 0:
                skipped.add(i)
            if is_angle and t.text != "<":
                depth = max(0, depth - len(t.text))
            if t.text == "[" and self.text(i + 1) == "[":
                skipped.update(range(i, self.partner[i] + 1))
            if t.text == "static_assert" and self._column(t.start) == 1:
                skipped.update(range(i, self.partner[i + 1] + 1))
        return skipped

    def _line(self, at):
        return bisect.bisect_right(self.line_starts, at)

    def _column(self, at):
        return at - self.line_starts[self._line(at) - 1] + 1

    def _site(self, start, end, new, what):
        line = self._line(start)
        begin = self.line_starts[line - 1]
        line_text = self.source[begin:].split("\n", 1)[0].strip()
        return Site(self.file, line, start - begin + 1, start, end, new, what, line_text)

    def _swap(self, i, new):
        t = self.tokens[i]
        return self._site(t.start, t.end, new, f"`{t.text}` -> `{new}`")

    def sites(self):
        found = []
        for i, t in enumerate(self.tokens):
            if i in self.skipped:
                continue
            if t.kind == "op":
                found += self._operator(i)
            elif t.kind == "number":
                found += self._constant(i)
            elif t.text in ("true", "false"):
                found.append(self._swap(i, "false" if t.text == "true" else "true"))
            elif t.text in ("if", "while"):
                found += self._condition(i)
            if self._begins_statement(i):
                found += self._statement(i)
        return found

    def _operator(self, i):
        text = self.text(i)
        if text == "!":
            t = self.tokens[i]
            operand = one_line(self.source[t.start :].split(";", 1)[0], 24)
            return [self._site(t.start, t.end, "", f"`!` removed before `{operand[1:]}`")]
        if text not in OPERATORS or not self._has_blanks(i) or self._is_output(i):
            return []
        return [self._swap(i, OPERATORS[text])]

    def _is_output(self, i):
        """`out << a << b;` is output: a statement whose value is not used is no shift."""
        if self.text(i) != "<<":
            return False
        first = i
        while first > 0 and not self._begins_statement(first):
            first -= 1
        return self.text(first + 1) == "<<"

    def _constant(self, i):
        m = re.fullmatch(r"(0[xX])?([0-9A-Fa-f']+?)([uUlLzZ]*)", self.text(i))
        if not m or (not m[1] and not m[2].replace("'", "").isdigit()):
            return []
        digits = m[2].replace("'", "")
        value = int(digits, 16 if m[1] else 10) + 1
        new = f"{m[1]}{value:0{len(digits)}X}{m[3]}" if m[1] else f"{value}{m[3]}"
        return [self._swap(i, new)]

    def _condition(self, i):
        opening = i + 1 + (self.text(i + 1) == "constexpr")
        if self.text(opening) != "(":
            return []
        closing = self.partner[opening]
        if any(self.text(k) in ("=", ";") for k in range(opening, closing)):
            return []  # it declares something
        if self.text(opening + 1) == "!" and not any(self.text(k) in ("&&", "||") for k in range(opening, closing)):
            return []  # the `!` is removed anyway
        start, end = self.tokens[opening].end, self.tokens[closing].start
        condition = self.source[start:end]
        return [self._site(start, end, f"!({condition})", f"`{one_line(condition, 40)}` negated")]

    def _begins_statement(self, i):
        around = self.inside[i]
        if around is None or self.text(around) != "{":
            return False
        before = self.text(i - 1)
        if before == ")":
            k = self.partner[i - 1] - 1
            return self.text(k) in ("if", "for", "while") or self.text(k - 1) == "if"
        if before == ":":  # of a label, not of `a ? b : c`
            k = i - 2
            while k > 0 and self.text(k) not in (";", "{", "}", "?", "case", "default"):
                k -= 1
            return self.text(k) in ("case", "default")
        return before in (";", "{", "}", "else", "do")

    def _statement(self, i):
        end = i
        while self.text(end) != ";":
            if self.text(end) in ("", "}"):
                return []
            end = self.partner[end] + 1 if self.text(end) in CLOSING else end + 1
        first, rest = self.text(i), self.text(i + 1)
        if first in ("return", "break", "continue"):
            # Where a value must be returned, only an early return can be removed.
            if first == "return" and rest != ";" and self.text(i - 1) != ")":
                return []
        elif not self._is_expression(i, end):
            return []
        start, stop = self.tokens[i].start, self.tokens[end].start
        return [self._site(start, stop, "", f"`{one_line(self.source[start:stop], 50)}` removed")]

    def _is_expression(self, i, end):
        """A call, an assignment or an increment; a declaration has two consecutive names."""
        if self.text(i) in ("++", "--"):
            return True
        if self.text(i) == "*":
            i += 1
        if self.tokens[i].kind != "word" or self.text(i) in KEYWORDS:
            return False
        i += 1
        while i < end:
            text = self.text(i)
            if text in ASSIGNMENTS:
                return self.text(i + 1) not in ("delete", "default")
            if text in ("++", "--") or (text == "<<" and i not in self.skipped):
                return True
            if text in ("(", "["):
                i = self.partner[i] + 1
            elif text in (".", "->", "::"):
                i += 2 + (self.text(i + 1) == "template")
            elif text == "<" and i in self.skipped:
                while i in self.skipped:
                    i += 1
            else:
                return False
        return self.text(end - 1) == ")"


def sites_of(root, files):
    """All changes of these files. Of two equal ones in a line the second has a number."""
    found, seen = [], {}
    for file in files:
        for s in sorted(Header(file, (root / file).read_text()).sites(), key=lambda s: s.start):
            nth = seen[file, s.line, s.what] = seen.get((file, s.line, s.what), 0) + 1
            found.append(s if nth == 1 else replace(s, what=f"{s.what} (no. {nth})"))
    return found


def chosen(sites, seed):
    """All sites in the order of the seed: first one of each line, then the second of each, so that a long expression
    does not displace the others. The place of a site depends on the text of its line, so an edit elsewhere hardly
    changes it."""

    def rank(*parts):
        return hashlib.sha256("\0".join(map(str, (seed, *parts))).encode()).digest()

    lines, seen = {}, {}
    for s in sites:
        lines.setdefault((s.file, s.line), []).append(s)
    ordered = []
    for (file, _), of_line in lines.items():
        text = of_line[0].line_text
        nth = seen[file, text] = seen.get((file, text), 0) + 1
        of_line = sorted(of_line, key=lambda s: rank(s.what, s.column))
        ordered += [(turn, rank(file, text, nth), s) for turn, s in enumerate(of_line)]
    return [s for _, _, s in sorted(ordered, key=lambda o: o[:2])]
