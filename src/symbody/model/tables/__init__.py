"""Tables: functions of one variable by points, in the model or in files beside it."""
