"""Energies of random tokens, evaluated or refused; the argument is a seed. Prints `done` and their number."""

import faulthandler
import random
import sys
import time

import numpy as np

import onset

RANDOM = random.Random(int(sys.argv[1]))
TOKENS = (
    ["I1", "I2", "J", "F11", "lambda1", "mu", "kappa", "1", "2.5", "1e308", "1e-320", "+", "-", "*", "/", "^", "(", ")", ",", "ln(", "exp(", "sqrt("]
    + ["max(", "if(", "<", "let a = ", ";", "tr(", "det(", "\u03bb", " ", "0/0", "..", "pow(", "((((((((", "1^1^1^1^"]
)
OPERATORS = ["+", "-", "*", "/", "^"]
LEAVES = ["I1", "I2", "J", "I1bar", "lambda1", "mu", "kappa", "1", "2.5", "1e-320", "F11"]
FUNCTIONS = ["ln", "exp", "sqrt", "abs", ""]


def tree(depth: int) -> str:
    """Formula that can be parsed."""
    if depth == 0:
        return RANDOM.choice(LEAVES)
    if RANDOM.random() < 0.3:
        return f"{RANDOM.choice(FUNCTIONS)}({tree(depth - 1)})"
    return f"({tree(depth - 1)}{RANDOM.choice(OPERATORS)}{tree(depth - 1)})"


faulthandler.enable()
# The harness ends a process that hangs; half of its limit is left for the last formula.
end = time.monotonic() + 5.0
count = 0
while time.monotonic() < end and count < 4000:
    is_tree = RANDOM.random() < 0.5
    energy = tree(RANDOM.randrange(6)) if is_tree else "".join(RANDOM.choices(TOKENS, k=RANDOM.choice([4, 12, 40])))
    try:
        onset.Material(energy=energy, mu=1.0, kappa=3.0).stress(np.diag([1.2, 0.9, 1.0]))
    except (onset.OnsetError, TypeError, ValueError) as error:
        if len(str(error)) > 2000:
            sys.exit(f"a long message: {str(error)[:200]}")
    count += 1
print("done", count)
