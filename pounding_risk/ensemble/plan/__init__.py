"""What a scan will run, hold in memory, compile and take, told before it starts."""
