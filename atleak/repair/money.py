"""Round amounts of money as people write them: to the currency's smallest unit, half of it upwards."""

from __future__ import annotations

from decimal import ROUND_HALF_UP, Decimal

# ISO 4217:2015, list one: minor units where they are not two.
_NONE = ("BIF", "CLP", "DJF", "GNF", "ISK", "JPY", "KMF", "KRW", "PYG", "RWF", "UGX", "VND", "VUV", "XAF", "XOF", "XPF")
_THREE = ("BHD", "IQD", "JOD", "KWD", "LYD", "OMR", "TND")


def decimals(currency: str) -> int:
    """Return how many decimals an amount of a currency has; two where nothing else is known.

    >>> decimals("EUR"), decimals("jpy"), decimals("KWD"), decimals("")
    (2, 0, 3, 2)
    """
    code = currency.strip().upper()
    return 0 if code in _NONE else 3 if code in _THREE else 2


def amount(value: float | Decimal, currency: str) -> Decimal:
    """Return an amount in the smallest units of its currency, half a unit rounded up, away from zero.

    A number counts as the decimal number that it is written as: 1.005 is one and five thousandths.

    >>> amount(1.005, "EUR"), amount(2.675, "PLN"), amount(0.5, "JPY"), amount(12.0, "EUR")
    (Decimal('1.01'), Decimal('2.68'), Decimal('1'), Decimal('12.00'))
    """
    exact = value if isinstance(value, Decimal) else Decimal(repr(float(value)))
    return exact.quantize(Decimal(1).scaleb(-decimals(currency)), ROUND_HALF_UP)


def product(first: float, second: float, currency: str) -> Decimal:
    """Return hours × rate, or the like, as an amount; the factors count as the decimal numbers they are written as.

    >>> product(1.15, 3.5, "EUR")
    Decimal('4.03')
    """
    return amount(Decimal(repr(float(first))) * Decimal(repr(float(second))), currency)
