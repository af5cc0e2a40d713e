"""The contract between clients and backends: requests, values, states and events."""
