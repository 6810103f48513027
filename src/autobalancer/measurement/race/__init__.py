"""Race, friction and drag from measurements on the balancer."""
