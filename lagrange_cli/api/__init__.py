"""What ``import lagrange_cli`` gives: functions of a system that return their results.

Each does what the command of the same name does. Where a command would end with an exit status other than 0,
a function raises an exception: ``LagrangeError`` with the same message, in the ``words`` of Python, or
``KeyboardInterrupt``. Warnings are ``LagrangeWarning``.
"""
