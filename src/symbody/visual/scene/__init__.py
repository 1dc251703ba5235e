"""What a mechanism looks like, as data that every picture is made from."""
