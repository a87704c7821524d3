"""What people see: figures, moving pictures, live panels, reports. Nothing here computes but panels at a press."""
