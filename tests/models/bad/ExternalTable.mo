model ExternalTable "An external object"
  class Table "Table in C"
    extends ExternalObject;
    function constructor "Open"
      output Table t "Table";
    external "C" t = openTable();
    end constructor;
    function destructor "Close"
      input Table t "Table";
    external "C" closeTable(t);
    end destructor;
  end Table;
  Table t = Table() "Table";
  Real x(unit="1", start=1, fixed=true) "State";
equation
  der(x) = -x;
end ExternalTable;
