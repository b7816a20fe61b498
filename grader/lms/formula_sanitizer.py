r"""Sanitize formulas in untrusted text, so that MathJax executes only commands on an allow-list.

Some MathJax commands create links and styles, load more commands, or define new names for such
commands. A formula with a command that is not on the list is therefore shown as source text. In
addition, a zero-width space separates the backslash of every such command from its name, inside and
outside formulas. This protects pages no matter how a program detects formulas.
"""

from __future__ import annotations

import re

ZERO_WIDTH_SPACE = "\u200b"

_LETTERS = """
alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigma tau
upsilon phi chi psi omega varepsilon vartheta varpi varrho varsigma varphi digamma varkappa
Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega varGamma varDelta varTheta varLambda
varXi varPi varSigma varUpsilon varPhi varPsi varOmega aleph beth gimel daleth hbar hslash imath
jmath ell wp Re Im partial infty prime backprime emptyset varnothing nabla eth mho Finv Game Bbbk
TeX LaTeX
"""
_SYMBOLS = """
top bot angle measuredangle sphericalangle triangle triangledown triangleq vartriangle square Box
lozenge Diamond blacktriangle blacktriangledown blacksquare blacklozenge bigstar backslash forall
exists nexists neg lnot flat natural sharp clubsuit diamondsuit heartsuit spadesuit surd complement
circledS circledR checkmark maltese yen diagup diagdown And degree
coprod prod sum int intop iint iiint iiiint idotsint oint smallint bigvee bigwedge biguplus bigcap
bigcup bigotimes bigoplus bigodot bigsqcup
wedge land vee lor cap cup Cap Cup doublecap doublecup ddagger dagger sqcap sqcup uplus amalg
diamond bullet wr div odot oslash otimes ominus oplus mp pm circ bigcirc setminus smallsetminus
cdot cdotp ldotp centerdot ast times star dotplus ltimes rtimes leftthreetimes rightthreetimes
barwedge veebar doublebarwedge curlywedge curlyvee boxminus boxtimes boxdot boxplus circleddash
circledast circledcirc divideontimes intercal triangleleft triangleright bigtriangleup
bigtriangledown
propto varpropto sqsubseteq sqsupseteq sqsubset sqsupset parallel shortparallel mid shortmid dashv
vdash vDash Vdash Vvdash models perp leq le geq ge lt gt leqq geqq leqslant geqslant eqslantless
eqslantgtr lesssim gtrsim lessapprox gtrapprox approxeq lessdot gtrdot lll llless ggg gggtr lessgtr
gtrless lesseqgtr gtreqless lesseqqgtr gtreqqless ll gg sim simeq backsim backsimeq thicksim eqsim
approx thickapprox cong equiv asymp doteq Doteq doteqdot risingdotseq fallingdotseq circeq eqcirc
bumpeq Bumpeq bowtie Join smile frown smallsmile smallfrown between pitchfork backepsilon therefore
because succ prec succeq preceq preccurlyeq succcurlyeq curlyeqprec curlyeqsucc precsim succsim
precapprox succapprox supset subset supseteq subseteq subseteqq supseteqq Subset Supset in ni notin
owns lhd rhd unlhd unrhd vartriangleleft vartriangleright trianglelefteq trianglerighteq
blacktriangleleft blacktriangleright
not ne neq nless ngtr nleq ngeq nleqslant ngeqslant nleqq ngeqq lneq gneq lneqq gneqq lvertneqq
gvertneqq lnsim gnsim lnapprox gnapprox nprec nsucc npreceq nsucceq precneqq succneqq precnsim
succnsim precnapprox succnapprox nsim ncong nshortmid nshortparallel nmid nparallel nvdash nvDash
nVdash nVDash ntriangleleft ntriangleright ntrianglelefteq ntrianglerighteq nsubseteq nsupseteq
nsubseteqq nsupseteqq subsetneq supsetneq varsubsetneq varsupsetneq subsetneqq supsetneqq
varsubsetneqq varsupsetneqq
"""
_ARROWS = """
leftarrow gets rightarrow to Leftarrow Rightarrow leftrightarrow Leftrightarrow longleftarrow
longrightarrow Longleftarrow Longrightarrow longleftrightarrow Longleftrightarrow iff implies
impliedby mapsto longmapsto uparrow downarrow updownarrow Uparrow Downarrow Updownarrow nearrow
searrow nwarrow swarrow leftharpoonup leftharpoondown rightharpoonup rightharpoondown
rightleftharpoons leftrightharpoons upharpoonleft upharpoonright downharpoonleft downharpoonright
restriction hookleftarrow hookrightarrow leftleftarrows rightrightarrows leftrightarrows
rightleftarrows Lleftarrow Rrightarrow twoheadleftarrow twoheadrightarrow leftarrowtail
rightarrowtail looparrowleft looparrowright curvearrowleft curvearrowright circlearrowleft
circlearrowright Lsh Rsh upuparrows downdownarrows multimap leftrightsquigarrow rightsquigarrow
leadsto dashrightarrow dashleftarrow nleftarrow nrightarrow nLeftarrow nRightarrow nleftrightarrow
nLeftrightarrow xrightarrow xleftarrow
"""
_FUNCTIONS = """
arcsin arccos arctan arg cos cosh cot coth csc deg det dim exp gcd hom inf injlim ker lg lim liminf
limsup ln log max min Pr projlim sec sin sinh sup tan tanh varliminf varlimsup varinjlim varprojlim
bmod pmod mod pod operatorname limits nolimits
"""
_CONSTRUCTS = """
frac dfrac tfrac cfrac binom dbinom tbinom sqrt root of over atop choose brace brack overset
underset stackrel buildrel sideset substack boxed fbox overline underline overbrace underbrace
overparen underparen overrightarrow underrightarrow overleftarrow underleftarrow overleftrightarrow
underleftrightarrow acute grave ddot dddot ddddot tilde bar breve check hat vec dot mathring
widetilde widehat widecheck cancel bcancel xcancel mathord mathop mathopen mathclose mathbin mathrel
mathpunct mathinner phantom vphantom hphantom smash strut mathstrut matrix pmatrix cases eqalign
displaylines cr newline hline hdashline hfill tag notag nonumber shoveleft shoveright
"""
_DELIMITERS = """
left right middle big Big bigg Bigg bigl Bigl biggl Biggl bigr Bigr biggr Biggr bigm Bigm biggm
Biggm langle rangle lfloor rfloor lceil rceil lvert rvert lVert rVert vert Vert lbrace rbrace lbrack
rbrack lgroup rgroup lmoustache rmoustache ulcorner urcorner llcorner lrcorner arrowvert Arrowvert
bracevert
"""
_SPACES = """
quad qquad enspace thinspace negthinspace negmedspace negthickspace nobreakspace space colon dots
ldots cdots vdots ddots dotsc dotsb dotsm dotsi dotso
"""
_FONTS = """
displaystyle textstyle scriptstyle scriptscriptstyle rm mit oldstyle cal it bf scr frak sf tt tiny
Tiny scriptsize small normalsize large Large LARGE huge Huge mathcal mathscr mathrm mathnormal
mathbf mathbb Bbb mathit mathfrak mathsf mathtt boldsymbol bm pmb text textrm textit textbf textsf
texttt textnormal mbox hbox
"""
COMMANDS = frozenset(
    (
        *_LETTERS.split(),
        *_SYMBOLS.split(),
        *_ARROWS.split(),
        *_FUNCTIONS.split(),
        *_CONSTRUCTS.split(),
        *_DELIMITERS.split(),
        *_SPACES.split(),
        *_FONTS.split(),
    )
)
_ENVIRONMENT = re.compile(
    r"\s{0,9}\{(?:array|subarray|(?:small|[pbBvV])?matrix|[dr]?cases|(?:equation|eqnarray|align|"
    r"alignat|multline|gather|split)\*?|aligned|alignedat|gathered)\}"
)
_COLOR = re.compile(r"\s{0,9}\{(?:[A-Za-z]{1,20}|#[0-9A-Fa-f]{3,6})\}")
_LENGTH = re.compile(r"\s{0,9}\{\s{0,9}\d{0,2}(?:\.\d{0,3})?\s{0,9}(?:em|ex|mu|pt|px|mm|cm|in)\}")
# Commands that are allowed only with these arguments.
WITH_ARGUMENT = {
    "begin": _ENVIRONMENT,
    "end": _ENVIRONMENT,
    "color": _COLOR,
    "textcolor": _COLOR,
    "hspace": _LENGTH,
}

# Names of one letter are not checked, because these commands draw at most one character.
_COMMAND = re.compile(r"\\([A-Za-z]{2,}+)")
_MATHJAX_TOKEN = re.compile(r"\\(?:([A-Za-z]{2,}+)|[\s\S])")
# Entities that become a backslash, or a letter of a command name, after formulas are detected.
_ENTITY = re.compile(
    r"&(?=#0*+(?:\d{1,2}|1[01]\d|12[0-7])(?!\d)|#[xX]0*+[0-7]?[0-9A-Fa-f](?![0-9A-Fa-f])|bsol;)"
)
_MAY_CONTAIN_FORMULAS = re.compile(r"[$&]|\\[(\[]|\\begin")
# Each alternative ends before the next match could begin, so no character is scanned twice. The
# groups are atomic, because Debian's Python 3.11.2 cannot match a possessive `(?:(?!...)...)*+`.
_FORMULA = re.compile(
    r"\$\$[^$]++\$\$|\$[^$]++\$"
    r"|\\\\?\[(?>(?:(?!\\\\?[\[\]])[\s\S])*)\\\\?\]"
    r"|\\\\?\((?>(?:(?!\\\\?[()])[\s\S])*)\\\\?\)"
    r"|\\begin\{(?>(?:(?!\\(?:begin|end)\{)[\s\S])*)\\end\{[A-Za-z]{1,20}\*?\}"
)


def sanitize_formulas(markdown: str) -> str:
    """Return Markdown in which MathJax finds only commands that draw mathematics.

    Returns
    -------
    str
        The Markdown; a formula with any other command becomes inline code.
    """
    if not _MAY_CONTAIN_FORMULAS.search(markdown):
        return markdown
    text = _FORMULA.sub(_as_code_if_unknown, markdown)
    text = _COMMAND.sub(_split_if_unknown, text)
    return _ENTITY.sub("&" + ZERO_WIDTH_SPACE, text)


def _as_code_if_unknown(formula: re.Match) -> str:
    commands = (match for match in _MATHJAX_TOKEN.finditer(formula[0]) if match[1])
    if all(map(_is_known, commands)):
        return formula[0]
    fence = "`" * (1 + max((len(run) for run in re.findall("`+", formula[0])), default=0))
    return f"{fence} {formula[0]} {fence}"


def _split_if_unknown(command: re.Match) -> str:
    return command[0] if _is_known(command) else f"\\{ZERO_WIDTH_SPACE}{command[1]}"


def _is_known(command: re.Match) -> bool:
    argument = WITH_ARGUMENT.get(command[1])
    if argument:
        return bool(argument.match(command.string, command.end()))
    return command[1] in COMMANDS
