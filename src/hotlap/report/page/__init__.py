"""Page: a study as one HTML file that opens without network, and reads without JavaScript.

study -> snapshot (what is recorded) -> replay (what is flown again) -> document (plain JSON) + still (HTML) -> template.html, filled
"""
