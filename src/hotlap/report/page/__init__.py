"""Page: a study as one HTML file that opens without a network, and can be read without JavaScript.

study -> snapshot (what is recorded) -> replay (what is flown again) -> document (JSON) and static (HTML) -> writing (template.html, filled)
"""
