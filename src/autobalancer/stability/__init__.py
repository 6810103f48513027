"""From which speed on the balancer works, how sure that is, and what happens otherwise."""
