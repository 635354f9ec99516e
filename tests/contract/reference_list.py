"""What the protocol reference lists, by model: instructions, and the errors that their answers may bear.

Copied by hand, not derived from what the fake servos know. Sources: ROBOTIS e-Manual, Protocol 2.0, Protocol 1.0, the
servos' pages; Feetech's SDKs (INST.h) and manuals.
"""

X_SERIES = ("xl330-m288", "xl330-m077", "xc330-m288", "xl430-w250", "xm430-w350")
MX = ("mx-28",)
AX = ("ax-12a",)
STS = ("sts3215", "sts3215-12v", "sts3250")
SCS = ("scs0009", "scs15")

_MX = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x08, 0x10, 0x82, 0x83, 0x92, 0x93}
_X = _MX | {0x20, 0x8A, 0x9A}  # control table backup and the fast reads came with later firmware, and not to the MX
_AX = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x83}
_SCS = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x0A, 0x83}
_STS = _SCS | {0x82}
INSTRUCTIONS = {
    **dict.fromkeys(X_SERIES, _X), **dict.fromkeys(MX, _MX), **dict.fromkeys(AX, _AX), **dict.fromkeys(STS, _STS),
    **dict.fromkeys(SCS, _SCS)}
_REBOOT, _REBOOT_AND_CALIBRATE = {0x08}, {0x08, 0x0B}
UNCERTAIN = {  # those that a servo has only if a switch of its file says so
    **dict.fromkeys(AX + SCS, _REBOOT), **dict.fromkeys(STS, _REBOOT_AND_CALIBRATE)}

# Protocol 2.0: numbers 1 to 7; bit 7, the alert, with an error or without. The others: bits.
ALERT = 0x80
_NUMBERS = {1, 2, 3, 4, 5, 6, 7, ALERT}
_BITS_1 = {0x01, 0x02, 0x04, 0x08, 0x10, 0x20, 0x40}
_BITS_STS, _BITS_SCS = {0x01, 0x02, 0x04, 0x08, 0x20}, {0x01, 0x04, 0x20}
ERRORS = {
    **dict.fromkeys(X_SERIES + MX, _NUMBERS), **dict.fromkeys(AX, _BITS_1),
    **dict.fromkeys(STS, _BITS_STS), **dict.fromkeys(SCS, _BITS_SCS)}
HARDWARE_ERRORS = {0x01, 0x04, 0x08, 0x10, 0x20}  # register 70 of the X series and the MX
