"""What ``import lagrange_cli`` gives: functions of a system that return what they have found.

Each does what the command of the same name does. What ends a command with an exit status other than 0 raises
here: ``LagrangeError`` with the same message, or ``KeyboardInterrupt``. Warnings are ``LagrangeWarning``.
"""
