"""Tests of the sentences that users are told."""

from mjxwalk.errors import near


def test_a_wrong_name_is_answered_by_those_close_to_it_else_by_all():
    assert near("snse", ["xnes", "snes", "ars"]) == "; did you mean snes or xnes?"
    assert near("zzz", ["xnes", "snes"]) == "; known are snes, xnes"
    assert near("zzz", []) == ""
