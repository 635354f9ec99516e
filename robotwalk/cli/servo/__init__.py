"""`robotwalk servo`: one line with servos on it, and no robot's file needed."""

from cyclopts import App

app = App(name="servo", help="Look at, set up and look after single servos on one serial line.")
app.command("robotwalk.cli.servo.look:scan")
app.command("robotwalk.cli.servo.look:ping")
app.command("robotwalk.cli.servo.registers:info")
app.command("robotwalk.cli.servo.registers:read")
app.command("robotwalk.cli.servo.registers:write")
app.command("robotwalk.cli.servo.watch:monitor")
app.command("robotwalk.cli.servo.act:torque_off")
app.command("robotwalk.cli.servo.act:reboot")
app.command("robotwalk.cli.servo.eeprom:backup")
app.command("robotwalk.cli.servo.eeprom:restore")
app.command("robotwalk.cli.servo.eeprom:factory_reset")
