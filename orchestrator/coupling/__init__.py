"""One machine made of solvers: motion goes down and loads go up in each sync interval.

Schemes order the members' calls, the mapping joins two meshes of one panel, the ledger books momentum and
energy at every interface, and ``build`` puts all of it together from a case.
"""
