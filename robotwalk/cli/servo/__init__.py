"""`robotwalk servo`: one line with servos on it, and no robot's file needed."""

from cyclopts import App

app = App(name="servo", help="Look at, set up and look after single servos on one serial line.")
app.command("robotwalk.cli.servo.look:scan", help="Find every servo: all baud rates, all protocols.")
app.command("robotwalk.cli.servo.look:ping", help="Ask one servo who it is.")
app.command("robotwalk.cli.servo.registers:info", help="Show everything that a servo says of itself.")
app.command("robotwalk.cli.servo.registers:read", help="Read registers by name, in their units.")
app.command("robotwalk.cli.servo.registers:write", help="Write registers by name, in their units, and read them back.")
app.command("robotwalk.cli.servo.watch:monitor", help="Show position, speed, load, voltage and heat, live.")
app.command("robotwalk.cli.servo.decode:decode", help="Print a log's or a line's traffic in words.")
app.command("robotwalk.cli.servo.address:set_id", help="Give a servo another id.")
app.command("robotwalk.cli.servo.address:set_baud", help="Give a servo another baud rate, and follow it.")
app.command("robotwalk.cli.servo.turn:wiggle", help="Turn a servo, or a robot's joint, a few degrees there and back.")
app.command("robotwalk.cli.servo.act:torque_off", help="Let servos go.")
app.command("robotwalk.cli.servo.act:reboot", help="Start a servo anew, and wait for it.")
app.command("robotwalk.cli.servo.adopt:adopt", help="Put a new servo into the place of a robot's old one.")
app.command("robotwalk.cli.servo.eeprom:backup", help="Save what a servo keeps without power to a file.")
app.command("robotwalk.cli.servo.eeprom:restore", help="Write a backup to a servo of the same model.")
app.command("robotwalk.cli.servo.eeprom:factory_reset", help="Set a servo back to what it was when new.")
