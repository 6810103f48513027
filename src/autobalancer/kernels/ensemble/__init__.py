"""Many runs of machines of one shape by one compiled loop, which needs neither Python nor its lock."""
